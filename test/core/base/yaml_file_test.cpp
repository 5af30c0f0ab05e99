#include "edge_mcl/core/base/yaml_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

using test::expectError;

class YamlFile : public test::WithFolder {
 protected:
  std::string written(const std::string& text) const {
    std::string file = path("file.yaml");
    std::ofstream(file) << text;
    return file;
  }
};

TEST_F(YamlFile, IsReadWithItsStructure) {
  const YAML::Node root = loadYamlFile(written("# a comment\nname: room\nsize: [4, 3.5, 2]\n"));
  ASSERT_TRUE(root.IsMap());
  EXPECT_EQ(root["name"].as<std::string>(), "room");
  EXPECT_EQ(root["size"].as<std::vector<double>>(), (std::vector<double>{4, 3.5, 2}));
}

TEST_F(YamlFile, WithoutContentIsNull) { EXPECT_TRUE(loadYamlFile(written("")).IsNull()); }

TEST_F(YamlFile, ThatIsMissingIsAnErrorWithItsName) {
  const std::string file = path("missing.yaml");
  expectError<InputError>(file + ": cannot be read", [&] { loadYamlFile(file); });
}

/// Every text breaks a rule of YAML 1.2: brackets that are not closed, a tab as indentation, a
/// quotation mark that is not closed, an alias without an anchor.
TEST_F(YamlFile, ThatIsNotYamlIsAnErrorWithItsName) {
  for (const char* broken : {"size: [4, 3", "room:\n\t- wall", "name: \"room", "name: *nobody"}) {
    const std::string file = written(broken);
    expectError<InputError>(file + ": not a YAML file", [&] { loadYamlFile(file); });
  }
}

/// A folder can be opened, but reading it throws std::ios_base::failure. loadYamlFile() lets this
/// error through instead of throwing InputError.
TEST_F(YamlFile, ThatIsAFolderIsAnError) {
  expectError<InputError>(folder_.string(), [&] { loadYamlFile(folder_.string()); });
}

}  // namespace
}  // namespace edge_mcl
