/// Model files for tests.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"

namespace edge_mcl::test {

inline std::string writeFile(const std::string& name, const std::string& text) {
  std::string file = testing::TempDir() + name;
  std::ofstream(file) << text;
  return file;
}

inline std::string textOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The text with `what`, which must occur in it, replaced by `by`.
inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

/// The text of the error that loading a file gives.
inline std::string errorOf(const std::string& file, const MapParameters& params = {}) {
  try {
    loadMesh(file, params);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace edge_mcl::test
