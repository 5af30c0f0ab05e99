/// File access for assimp that ends what would not end by itself.
#pragma once

#include <assimp/DefaultIOSystem.h>

namespace edge_mcl {

/// Some of assimp's readers (5.2: PLY without "end_header") ask for more data for ever when a file
/// ends too early. Streams of this file system throw std::runtime_error after many vain reads in
/// sequence, which assimp turns into a failed import.
class GuardedFileSystem : public Assimp::DefaultIOSystem {
 public:
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;
};

}  // namespace edge_mcl
