/// Data that are computed from a model and kept on disk, so that the next start reads them.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

/// FNV-1a hash over 32-bit words.
class ContentHash {
 public:
  template <class T>
  void add(const T* data, size_t count) {
    static_assert(sizeof(T) % 4 == 0);
    addWords(reinterpret_cast<const char*>(data), count * sizeof(T) / 4);
  }
  uint64_t value() const { return value_; }

 private:
  void addWords(const char* bytes, size_t words) {
    for (size_t i = 0; i < words; ++i) {
      uint32_t word = 0;
      std::memcpy(&word, bytes + 4 * i, 4);
      value_ = (value_ ^ word) * 1099511628211ull;
    }
  }
  uint64_t value_ = 14695981039346656037ull;
};

/// What a stored file holds, and what it was made from.
struct StoredKind {
  char magic[9];     ///< eight characters: the format and its version
  const char* name;  ///< for messages, with its article: "a distance field"
};

/// One block of bytes of a stored file. Its size is a multiple of four.
struct StoredPart {
  const void* data;
  size_t bytes;
};

/// Writes parts to a binary file of this machine's byte order. The file gets its name when it is
/// complete, because another process may read or write the same data.
/// @param hash of everything that determines the data.
/// @throws InputError when the file cannot be written.
void writeStored(const std::string& file, const StoredKind& kind, uint64_t hash,
                 const std::vector<StoredPart>& parts);

/// Reads what writeStored() has written.
class StoredReader {
 public:
  /// Checks the beginning and the size of the file.
  /// @throws InputError when the file is missing or broken, or has another hash.
  StoredReader(const std::string& file, const StoredKind& kind, uint64_t hash, size_t parts);
  /// Number of elements of a part. @throws InputError when it holds no whole number of them.
  template <class T>
  size_t count(size_t part) const {
    if (sizes_[part] % sizeof(T) != 0) throw InputError(file_ + ": damaged");
    return sizes_[part] / sizeof(T);
  }
  /// Reads the next part, which has count<T>() elements.
  template <class T>
  void read(T* data) {
    readBytes(data);
  }
  /// To be called after the last part. @throws InputError when the checksum is wrong.
  void finish();

 private:
  void readBytes(void* data);

  std::string file_;
  std::ifstream in_;
  uint64_t checksum_ = 0;
  ContentHash hash_;
  std::vector<uint64_t> sizes_;
  size_t next_ = 0;
};

/// Files in which data of a model may be kept, best first: beside the model, then in
/// $XDG_CACHE_HOME/edge_mcl or ~/.cache/edge_mcl.
/// @param extension e.g. "field".
std::vector<std::string> storagePlaces(const std::string& model_file, uint64_t hash,
                                       const char* extension);

/// Tries to read from the files. @param read throws InputError when a file does not hold the data.
/// @return whether one was read.
bool readFromOne(const std::vector<std::string>& files,
                 const std::function<void(const std::string&)>& read);
/// Writes to the first file that can be written. @param write throws InputError when it cannot.
/// @return an empty text, or why no file could be written.
std::string writeToOne(const std::vector<std::string>& files,
                       const std::function<void(const std::string&)>& write);

}  // namespace edge_mcl
