#include "edge_mcl/core/image/picture_file.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class PictureFile : public testing::Test {
 protected:
  PictureFile() : directory_(fs::temp_directory_path() / "edge_mcl_picture_file_test") {
    fs::remove_all(directory_);
    fs::create_directories(directory_);
  }
  ~PictureFile() override { fs::remove_all(directory_); }
  std::string file(const char* name) const { return (directory_ / name).string(); }

  const fs::path directory_;
};

/// A picture of noise. It does not compress, so the file is written in several blocks.
cv::Mat noise() {
  cv::Mat picture(400, 640, CV_8UC3);
  cv::randu(picture, 0, 256);
  return picture;
}

TEST_F(PictureFile, HoldsThePicture) {
  const cv::Mat picture = noise();
  writePicture(file("a.png"), picture);
  EXPECT_EQ(cv::norm(cv::imread(file("a.png")), picture, cv::NORM_INF), 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
}

/// One thread rewrites the file, another one reads it all the time. It must never read a part of a
/// file.
TEST_F(PictureFile, WhoeverWaitsForItNeverReadsHalf) {
  std::atomic<bool> done{false};
  std::atomic<int> seen{0}, broken{0};
  std::thread reader([&] {
    // A complete PNG ends with its IEND chunk.
    while (!done) {
      std::ifstream in(file("a.png"), std::ios::binary);
      const std::string bytes((std::istreambuf_iterator<char>(in)), {});
      if (!in.is_open() || bytes.empty()) {
        broken += in.is_open();
        continue;
      }
      ++seen;
      broken += bytes.size() < 8 || bytes.compare(bytes.size() - 8, 4, "IEND") != 0;
    }
  });
  const cv::Mat picture = noise();
  for (int i = 0; i < 30 || (seen == 0 && i < 3000); ++i) writePicture(file("a.png"), picture);
  done = true;
  reader.join();
  EXPECT_GT(seen, 0);
  EXPECT_EQ(broken, 0);
}

TEST_F(PictureFile, SaysWhatIsWrong) {
  EXPECT_THROW(writePicture(file("none/a.png"), noise()), InputError);
  EXPECT_THROW(writePicture(file("a.picture"), noise()), InputError);
  EXPECT_THROW(writePicture(file("a"), noise()), InputError);
  EXPECT_THROW(writePicture(file("a.png"), cv::Mat()), InputError);
  EXPECT_TRUE(fs::is_empty(directory_));
}

}  // namespace
}  // namespace edge_mcl
