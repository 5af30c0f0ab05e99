/// A folder for the files of one test.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace edge_mcl::test {

/// Fixture with an empty folder. The folder is removed after the test.
class WithFolder : public testing::Test {
 protected:
  WithFolder()
      : folder_(std::filesystem::temp_directory_path() /
                ("edge_mcl_" + std::string(nameOfTest()) + "_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~WithFolder() override { std::filesystem::remove_all(folder_); }
  /// Path of a file in the folder.
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  const std::filesystem::path folder_;

 private:
  static const char* nameOfTest() {
    return testing::UnitTest::GetInstance()->current_test_info()->name();
  }
};

}  // namespace edge_mcl::test
