/// File access for assimp that ends endless reading.
#pragma once

#include <assimp/DefaultIOSystem.h>

namespace edge_mcl {

/// Opens files for assimp and stops readers that never end. Some readers of assimp (5.2: PLY
/// without "end_header") ask for more data forever when a file ends too early. The streams of this
/// file system throw std::runtime_error after more than 10000 empty reads in a row. assimp turns
/// the exception into a failed import.
class GuardedFileSystem : public Assimp::DefaultIOSystem {
 public:
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;
};

}  // namespace edge_mcl
