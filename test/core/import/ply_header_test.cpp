#include "edge_mcl/core/import/ply_header.h"

#include <gtest/gtest.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

class PlyHeader : public test::WithFolder {
 protected:
  std::string written(const std::string& text) const {
    std::string file = path("model.ply");
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  void expectGood(const std::string& text) const {
    EXPECT_NO_THROW(checkPlyHeader(written(text))) << text;
  }
  /// The error must name the file, and contain a piece of text.
  void expectFault(const std::string& text, const std::string& piece) const {
    const std::string file = written(text);
    test::expectError<InputError>(file, [&] { checkPlyHeader(file); });
    test::expectError<InputError>(piece, [&] { checkPlyHeader(file); });
  }
};

/// A header with one line more, as its fourth line.
std::string withLine(const std::string& line) {
  return "ply\nformat ascii 1.0\nelement vertex 8\n" + line + "\nend_header\n0 0 0\n";
}

/// The first header is the example of G. Turk, "The PLY Polygon File Format".
TEST_F(PlyHeader, ThatFollowsTheGrammarIsAccepted) {
  expectGood(
      "ply\nformat ascii 1.0\ncomment made by Greg Turk\ncomment this file is a cube\n"
      "element vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\n"
      "property list uchar int vertex_index\nend_header\n0 0 0\n");
  expectGood("ply\nformat binary_little_endian 1.0\nelement vertex 0\nend_header\n");
  expectGood("ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty float x\r\nend_header\r\n0");
  for (const char* type :
       {"char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint8",
        "int16", "uint16", "int32", "uint32", "float32", "float64"}) {
    expectGood(withLine(std::string("property ") + type + " x"));
    expectGood(withLine(std::string("property list ") + type + ' ' + type + " x"));
  }
  expectGood(withLine("obj_info num_cols 512"));
  expectGood(withLine("comment"));
  expectGood(
      withLine("comment M\xc3\xb6"
               "bel\twith a tab"));
  expectGood(withLine("  property   float  x  "));
}

/// What follows the header is not examined.
TEST_F(PlyHeader, TheDataMayBeBinary) {
  expectGood("ply\nformat binary_big_endian 1.0\nend_header\n" + std::string("\0\x01\xff\n\0", 5));
}

TEST_F(PlyHeader, TheFaultyLineIsNamed) {
  expectFault("PLY\nformat ascii 1.0\nend_header\n", "line 1 of the PLY header is not 'ply'");
  for (const char* line :
       {"elements vertex 8", "element vertex", "element vertex 8 9", "element vertex -8",
        "element vertex 8.5", "element vertex many", "element vertex 12345678901", "property float",
        "property real x", "property float x y", "property list uchar int",
        "property list uchar vertex int", "property lists uchar int x", "format ascii", "",
        "0 0 0"}) {
    expectFault(withLine(line), "line 4 of the PLY header is not understood");
    expectFault(withLine(line), line);
  }
}

TEST_F(PlyHeader, ControlCharactersAreNotText) {
  expectFault(withLine(std::string("el\0ment vertex 8", 16)),
              "line 4 of the PLY header is not text");
  expectFault(withLine("comment \x1b[31m"), "line 4 of the PLY header is not text");
}

TEST_F(PlyHeader, ThatDoesNotEndIsAnError) {
  expectFault("", "line 1 of the PLY header is cut off");
  expectFault("ply", "line 1 of the PLY header is cut off");
  expectFault("ply\nformat ascii 1.0\n", "line 3 of the PLY header is cut off");
  expectFault("ply\nformat ascii 1.0\nend_head", "line 3 of the PLY header is cut off");
  std::string endless = "ply\n";
  for (int i = 0; i < 5000; ++i) endless += "comment\n";
  expectFault(endless, "the PLY header does not end");
  expectFault("ply\nelement " + std::string(1000000, 'x'), "line 2 of the PLY header");
}

TEST_F(PlyHeader, AMissingFileIsAnError) {
  const std::string file = path("missing.ply");
  test::expectError<InputError>(file, [&] { checkPlyHeader(file); });
}

/// The grammar does not limit the length of a line.
TEST_F(PlyHeader, ALongCommentIsAccepted) {
  expectGood(withLine("comment " + std::string(2000, 'x')));
}

}  // namespace
}  // namespace edge_mcl
