/// Import of a model file in a process of its own.
#pragma once

#include <functional>
#include <string>

#include "edge_mcl/core/import/raw_model.h"

namespace edge_mcl {

/// Limits of the process that imports a file.
struct ImportLimits {
  double seconds = 0;    ///< 0: 20 s, and 2 s more for each megabyte of the file
  double gigabytes = 0;  ///< of memory; 0: 4 GB, and 60 times the size of the file
};

/// Reads a model file in a child process, so that an importer that crashes, hangs or takes all
/// memory on a broken file does not end this process.
/// @throws InputError that names the file when it cannot be read or a limit is exceeded.
/// @throws Error when the child process cannot be started.
RawModel importModel(const std::string& file, const ImportLimits& limits);

/// The child's side: reads the file and writes the model, or the reason why there is none, to a
/// file descriptor. It does not return.
/// @param descriptor of an empty file. @param read reads the file.
[[noreturn]] void runImporter(const std::string& file, int descriptor, uint64_t bytes_of_memory,
                              const std::function<RawModel(const std::string&)>& read);

}  // namespace edge_mcl
