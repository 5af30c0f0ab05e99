#include "edge_mcl/core/import/guarded_file_system.h"

#include <assimp/MemoryIOWrapper.h>

#include <assimp/IOStream.hpp>
#include <memory>
#include <stdexcept>

namespace edge_mcl {

namespace {

class GuardedStream : public Assimp::IOStream {
 public:
  explicit GuardedStream(Assimp::IOStream* stream) : stream_(stream) {}

  size_t Read(void* buffer, size_t size, size_t count) override {
    constexpr int kMostVainReads = 10000;
    const size_t got = stream_->Read(buffer, size, count);
    vain_reads_ = got == 0 ? vain_reads_ + 1 : 0;
    if (vain_reads_ > kMostVainReads) throw std::runtime_error("the file ends too early");
    return got;
  }
  size_t Write(const void* buffer, size_t size, size_t count) override {
    return stream_->Write(buffer, size, count);
  }
  aiReturn Seek(size_t offset, aiOrigin origin) override { return stream_->Seek(offset, origin); }
  size_t Tell() const override { return stream_->Tell(); }
  size_t FileSize() const override { return stream_->FileSize(); }
  void Flush() override { stream_->Flush(); }

 private:
  std::unique_ptr<Assimp::IOStream> stream_;
  int vain_reads_ = 0;
};

}  // namespace

Assimp::IOStream* GuardedFileSystem::Open(const char* file, const char* mode) {
  Assimp::IOStream* stream =
      !replaced_.empty() && replaced_ == file
          ? new Assimp::MemoryIOStream(reinterpret_cast<const uint8_t*>(contents_.data()),
                                       contents_.size())
          : DefaultIOSystem::Open(file, mode);
  return stream ? new GuardedStream(stream) : nullptr;
}

void GuardedFileSystem::Close(Assimp::IOStream* stream) { delete stream; }

}  // namespace edge_mcl
