#include "edge_mcl/core/import/ply_header.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <vector>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// A header within these limits is read in a moment. Programs write comments of some kilobytes.
constexpr size_t kLongestLine = 65536, kMostLines = 1000;

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> result;
  for (std::string word; in >> word;) result.push_back(word);
  return result;
}

bool isType(const std::string& word) {
  static const std::array<const char*, 16> kTypes{
      "char", "uchar", "short", "ushort", "int",   "uint",   "float",   "double",
      "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
  return std::find(kTypes.begin(), kTypes.end(), word) != kTypes.end();
}

/// Whether a word is a count that a file can hold: one to ten digits.
bool isCount(const std::string& word) {
  return !word.empty() && word.size() <= 10 &&
         word.find_first_not_of("0123456789") == std::string::npos;
}

bool isGood(const std::vector<std::string>& w) {
  const std::string& keyword = w.front();
  if (keyword == "comment" || keyword == "obj_info") return true;
  if (keyword == "format") return w.size() == 3;
  if (keyword == "element") return w.size() == 3 && isCount(w[2]);
  if (keyword != "property") return false;
  if (w.size() == 5) return w[1] == "list" && isType(w[2]) && isType(w[3]);
  return w.size() == 3 && isType(w[1]);
}

}  // namespace

void checkPlyHeader(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const auto fail = [&](size_t number, const std::string& what) {
    throw InputError(file + ": line " + std::to_string(number) + " of the PLY header " + what);
  };
  std::string line;
  for (size_t number = 1; number <= kMostLines; ++number) {
    line.clear();
    char c = 0;
    while (in.get(c) && c != '\n' && line.size() < kLongestLine) line += c;
    if (!in) fail(number, "is cut off");
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (std::any_of(line.begin(), line.end(), [](unsigned char x) { return x < 32 && x != '\t'; }))
      fail(number, "is not text");
    const std::vector<std::string> w = words(line);
    if (number == 1) {
      if (line != "ply") fail(number, "is not 'ply'");
      continue;
    }
    if (w.size() == 1 && w.front() == "end_header") return;
    if (w.size() == 3 && w[0] == "element" && w[1] == "tristrips")
      fail(number,
           "announces triangle strips, which cannot be read here. Open the file in MeshLab "
           "and save it again");
    if (w.empty() || !isGood(w)) fail(number, "is not understood: '" + line.substr(0, 60) + "'");
  }
  throw InputError(file + ": the PLY header does not end");
}

}  // namespace edge_mcl
