#include "edge_mcl/core/import/guarded_file_system.h"

#include <gtest/gtest.h>

#include <assimp/IOStream.hpp>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "support/error_text.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

constexpr int kMostVainReads = 10000;

class GuardedFile : public test::WithFolder {
 protected:
  GuardedFile() {
    std::ofstream(path("file.txt"), std::ios::binary) << "0123456789";
    stream_ = files_.Open(path("file.txt").c_str(), "rb");
  }
  ~GuardedFile() override { files_.Close(stream_); }
  /// The next characters of the file, at most `count`.
  std::string read(size_t count) {
    std::string text(count, '\0');
    text.resize(stream_->Read(text.data(), 1, count));
    return text;
  }
  GuardedFileSystem files_;
  Assimp::IOStream* stream_ = nullptr;
};

TEST_F(GuardedFile, IsReadAsItIs) {
  ASSERT_NE(stream_, nullptr);
  EXPECT_EQ(stream_->FileSize(), 10u);
  EXPECT_EQ(read(4), "0123");
  EXPECT_EQ(stream_->Tell(), 4u);
  EXPECT_EQ(read(100), "456789");
  EXPECT_EQ(stream_->Seek(8, aiOrigin_SET), aiReturn_SUCCESS);
  EXPECT_EQ(read(1), "8");
}

TEST_F(GuardedFile, EndlessReadingBeyondTheEndIsAnError) {
  read(10);
  for (int i = 0; i < kMostVainReads; ++i) ASSERT_EQ(read(1), "");
  test::expectError<std::runtime_error>("ends too early", [&] { read(1); });
}

/// Only empty reads in a row count. A read that returns data starts the count anew.
TEST_F(GuardedFile, EmptyReadsBetweenOthersAreNoError) {
  for (int round = 0; round < 3; ++round) {
    stream_->Seek(0, aiOrigin_SET);
    ASSERT_EQ(read(10), "0123456789");
    for (int i = 0; i < kMostVainReads; ++i) ASSERT_EQ(read(1), "");
  }
}

TEST_F(GuardedFile, ThatIsMissingIsNull) {
  EXPECT_EQ(files_.Open(path("missing.txt").c_str(), "rb"), nullptr);
  EXPECT_FALSE(files_.Exists(path("missing.txt").c_str()));
  EXPECT_TRUE(files_.Exists(path("file.txt").c_str()));
}

TEST_F(GuardedFile, CanBeWritten) {
  Assimp::IOStream* const out = files_.Open(path("new.txt").c_str(), "wb");
  ASSERT_NE(out, nullptr);
  EXPECT_EQ(out->Write("abc", 1, 3), 3u);
  out->Flush();
  files_.Close(out);
  std::string text;
  std::ifstream(path("new.txt")) >> text;
  EXPECT_EQ(text, "abc");
}

}  // namespace
}  // namespace edge_mcl
