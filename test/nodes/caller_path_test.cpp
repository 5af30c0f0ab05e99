// Tests that relative names of files mean the folder of the caller.
#include "edge_mcl/nodes/common/caller_path.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

/// As under roslaunch: the process is in one folder, PWD names another.
class CallerPath : public testing::Test {
 protected:
  void SetUp() override {
    pwd_ = std::getenv("PWD") != nullptr ? std::getenv("PWD") : "";
    was_ = fs::current_path();
    for (const fs::path& folder : {here_, caller_}) fs::create_directories(folder);
    fs::current_path(here_);
    setenv("PWD", caller_.c_str(), 1);
  }
  void TearDown() override {
    fs::current_path(was_);
    setenv("PWD", pwd_.c_str(), 1);
    fs::remove_all(here_);
    fs::remove_all(caller_);
  }
  const fs::path here_ = fs::path(testing::TempDir()) / "caller_path_here",
                 caller_ = fs::path(testing::TempDir()) / "caller_path_caller";
  std::string pwd_;
  fs::path was_;
};

TEST_F(CallerPath, IsLookedForWhereTheCallerIs) {
  std::ofstream(caller_ / "a.obj") << "x";
  std::ofstream(here_ / "a.obj") << "old";
  std::ofstream(here_ / "b.obj") << "x";
  EXPECT_EQ(callerPath("a.obj"), (caller_ / "a.obj").string());
  EXPECT_EQ(callerPath("b.obj"), "b.obj");
  EXPECT_EQ(callerPath("/c.obj"), "/c.obj");
  EXPECT_EQ(callerPath(""), "");
}

TEST_F(CallerPath, BothFoldersAreNamedWhenItIsInNeither) {
  const std::string error = test::errorText<InputError>([] { callerPath("none.obj"); });
  EXPECT_NE(error.find(here_.filename().string()), std::string::npos) << error;
  EXPECT_NE(error.find(caller_.filename().string()), std::string::npos) << error;
}

}  // namespace
}  // namespace edge_mcl
