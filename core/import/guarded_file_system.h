/// File access for assimp that ends endless reading.
#pragma once

#include <assimp/DefaultIOSystem.h>

#include <string>

namespace edge_mcl {

/// Opens files for assimp and stops readers that never end. Some readers of assimp (5.2: PLY
/// without "end_header") ask for more data forever when a file ends too early. The streams of this
/// file system throw std::runtime_error after more than 10000 empty reads in a row. assimp turns
/// the exception into a failed import.
class GuardedFileSystem : public Assimp::DefaultIOSystem {
 public:
  GuardedFileSystem() = default;
  /// Shows other contents in place of one file.
  GuardedFileSystem(std::string file, std::string contents)
      : replaced_(std::move(file)), contents_(std::move(contents)) {}
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;

 private:
  std::string replaced_, contents_;
};

}  // namespace edge_mcl
