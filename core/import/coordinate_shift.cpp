#include "edge_mcl/core/import/coordinate_shift.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "edge_mcl/core/import/file_facts.h"
#include "edge_mcl/core/import/map_frame.h"
#include "edge_mcl/core/import/obj_names.h"

namespace edge_mcl {

namespace {

/// Single precision rounds coordinates of this size by at most 0.06 thousandths of the unit.
constexpr double kFar = 2000;
/// A point of an IFC file that is farther than this from its placement is given in coordinates of a
/// country, m. No building is as large.
constexpr double kFarIfc = 10000;

/// Place of a number in the text.
struct Number {
  size_t begin = 0, end = 0;
  double value = 0;
};
using Triple = std::array<Number, 3>;
using Found = std::function<void(const Triple&)>;

bool isSeparator(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == '\n' || c == '\r' || c == '(';
}

/// Reads the next number before `end`. @return false when something else stands there.
bool nextNumber(const std::string& text, size_t* at, size_t end, Number* number) {
  while (*at < end && isSeparator(text[*at])) ++*at;
  number->begin = *at;
  const char* first = text.data() + *at;
  if (*at < end && *first == '+') ++first;  // from_chars knows no plus sign
  const auto [last, error] = std::from_chars(first, text.data() + end, number->value);
  if (error != std::errc() || !std::isfinite(number->value)) return false;
  *at = number->end = static_cast<size_t>(last - text.data());
  return true;
}

bool nextTriple(const std::string& text, size_t* at, size_t end, Triple* triple) {
  return std::all_of(triple->begin(), triple->end(),
                     [&](Number& n) { return nextNumber(text, at, end, &n); });
}

/// Calls `found` for the three numbers after every `word` at the beginning of a line.
/// @return false when something else follows a word, or the line goes on in the next one.
bool triplesAfterWord(const std::string& text, const std::string& word, const Found& found) {
  for (size_t line = 0; line < text.size();) {
    size_t end = text.find('\n', line);
    if (end == std::string::npos) end = text.size();
    size_t at = line;
    while (at < end && (text[at] == ' ' || text[at] == '\t')) ++at;
    Triple triple;
    if (text.compare(at, word.size(), word) == 0 && at + word.size() < end &&
        isSeparator(text[at + word.size()])) {
      at += word.size();
      const size_t last = end > line ? text.find_last_not_of(" \t\r", end - 1) : line;
      if (text[last] == '\\' || !nextTriple(text, &at, end, &triple)) return false;
      found(triple);
    }
    line = end + 1;
  }
  return true;
}

/// Points of an IFC file. Only those with a far coordinate are positions in the country; others are
/// relative to a placement.
bool ifcPoints(const std::string& text, double far, const Found& found) {
  constexpr std::string_view kPoint = "IFCCARTESIANPOINT(";
  for (size_t at = text.find(kPoint); at != std::string::npos; at = text.find(kPoint, at)) {
    at += kPoint.size();
    const size_t end = std::min(text.find(';', at), text.size());
    Triple triple;
    if (nextTriple(text, &at, end, &triple) &&
        std::any_of(triple.begin(), triple.end(),
                    [&](const Number& n) { return std::abs(n.value) > far; }))
      found(triple);
  }
  return true;  // other points have two numbers
}

std::string attribute(const std::string& text, size_t tag, const std::string& name) {
  const size_t end = text.find('>', tag);
  const size_t at = text.find(name + "=\"", tag);
  if (at == std::string::npos || at > end) return "";
  const size_t first = at + name.size() + 2;
  return text.substr(first, text.find('"', first) - first);
}

/// Positions of a Collada file: the arrays of the sources whose semantic is POSITION.
/// @return false when an array holds something else than numbers.
bool colladaPositions(const std::string& text, const Found& found) {
  for (size_t input = text.find("\"POSITION\""); input != std::string::npos;
       input = text.find("\"POSITION\"", input + 1)) {
    const size_t tag = text.rfind('<', input);
    if (tag == std::string::npos) continue;
    const std::string id = attribute(text, tag, "source");
    if (id.size() < 2) continue;
    const size_t source = text.find("id=\"" + id.substr(1) + "\"");
    const size_t array = source == std::string::npos ? source : text.find("<float_array", source);
    if (array == std::string::npos) continue;
    size_t at = text.find('>', array);
    const size_t end = std::min(text.find('<', at), text.size());
    if (at == std::string::npos) continue;
    ++at;
    for (Triple triple; nextTriple(text, &at, end, &triple);) found(triple);
    while (at < end && isSeparator(text[at])) ++at;
    if (at < end) return false;
  }
  return true;
}

/// Header of a PLY file whose vertices are the first element.
struct PlyVertices {
  bool ascii = false, little_endian = false;
  size_t begin = 0, count = 0, size = 0;  ///< first byte, number, and bytes of a vertex
  std::array<size_t, 3> offset{};         ///< of x, y and z in a vertex: bytes, or columns
  std::array<bool, 3> is_double{};
};

bool plyVertices(const std::string& text, PlyVertices* ply) {
  const size_t end = text.find("end_header");
  if (end == std::string::npos) return false;
  ply->begin = text.find('\n', end) + 1;
  size_t column = 0;
  bool in_vertex = false, had_element = false;
  for (size_t line = 0; line < end;) {
    const size_t next = text.find('\n', line);
    char a[32] = "", b[32] = "", c[32] = "";
    std::sscanf(text.substr(line, std::min<size_t>(next - line, 90)).c_str(), "%31s %31s %31s", a,
                b, c);
    const std::string first = a, second = b, third = c;
    if (first == "format") {
      ply->ascii = second == "ascii";
      ply->little_endian = second == "binary_little_endian";
    } else if (first == "element") {
      if (!had_element && second != "vertex") return false;
      in_vertex = second == "vertex";
      had_element = true;
      if (in_vertex) std::from_chars(third.data(), third.data() + third.size(), ply->count);
    } else if (first == "property" && in_vertex) {
      if (second == "list") return false;
      const bool eight = second == "double" || second == "float64";
      const bool one =
          second.find("char") != std::string::npos || second == "int8" || second == "uint8";
      const bool two =
          second.find("short") != std::string::npos || second.find("16") != std::string::npos;
      const size_t bytes = eight ? 8 : one ? 1 : two ? 2 : 4;
      for (size_t k = 0; k < 3; ++k)
        if (third == std::string(1, static_cast<char>('x' + k))) {
          ply->offset[k] = ply->ascii ? column : ply->size;
          ply->is_double[k] = eight;
        }
      ply->size += bytes;
      ++column;
    }
    line = next + 1;
  }
  return ply->count > 0;
}

/// Positions of a PLY file of text. @return false when a line lacks a number.
bool plyPositions(const std::string& text, const PlyVertices& ply, const Found& found) {
  size_t line = ply.begin;
  for (size_t i = 0; i < ply.count && line < text.size();) {
    size_t end = text.find('\n', line);
    if (end == std::string::npos) end = text.size();
    if (text.find_first_not_of(" \t\r", line) >= end) {  // importers skip empty lines
      line = end + 1;
      continue;
    }
    ++i;
    Triple triple;
    size_t at = line, column = 0;
    for (Number n; nextNumber(text, &at, end, &n); ++column)
      for (size_t k = 0; k < 3; ++k)
        if (ply.offset[k] == column) triple[k] = n;
    if (column <= *std::max_element(ply.offset.begin(), ply.offset.end())) return false;
    found(triple);
    line = end + 1;
  }
  return true;
}

Eigen::Vector3d valueOf(const Triple& t) { return {t[0].value, t[1].value, t[2].value}; }

/// Writes the text again with the numbers that `each` finds moved by -shift.
std::string rewritten(const std::string& text, const Eigen::Vector3d& shift,
                      const std::function<bool(const Found&)>& each) {
  std::string result;
  result.reserve(text.size());
  size_t copied = 0;
  each([&](const Triple& triple) {
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return triple[a].begin < triple[b].begin; });
    for (const int k : order) {
      // Collada may share one array between two meshes. Its numbers are moved once.
      if (shift[k] == 0 || triple[k].begin < copied) continue;
      result.append(text, copied, triple[k].begin - copied);
      std::array<char, 40> number{};
      std::snprintf(number.data(), number.size(), "%.9f", triple[k].value - shift[k]);
      // Without zeros at its end the number is read as it would be without the shift.
      std::string shortest = number.data();
      shortest.erase(shortest.find_last_not_of('0') + 1);
      result += shortest;
      copied = triple[k].end;
    }
  });
  result.append(text, copied, std::string::npos);
  return result;
}

/// Coordinate of a binary PLY file.
class BinaryNumber {
 public:
  BinaryNumber(char* place, bool little_endian) : place_(place), little_endian_(little_endian) {}
  double get() const {
    std::array<char, sizeof(double)> bytes{};
    std::copy(place_, place_ + bytes.size(), bytes.begin());
    if (!little_endian_) std::reverse(bytes.begin(), bytes.end());
    double value = 0;
    std::memcpy(&value, bytes.data(), sizeof(value));
    return value;
  }
  void set(double value) {
    std::array<char, sizeof(double)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(value));
    if (!little_endian_) std::reverse(bytes.begin(), bytes.end());
    std::copy(bytes.begin(), bytes.end(), place_);
  }

 private:
  char* place_;
  bool little_endian_;
};

std::optional<ShiftedFile> shiftedBinaryPly(std::string contents, const PlyVertices& ply) {
  if (!(ply.is_double[0] && ply.is_double[1] && ply.is_double[2]) ||
      ply.begin + ply.count * ply.size > contents.size())
    return std::nullopt;
  const auto number = [&](size_t i, int k) {
    return BinaryNumber(contents.data() + ply.begin + i * ply.size + ply.offset[k],
                        ply.little_endian);
  };
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < ply.count; ++i) {
    const Eigen::Vector3d p(number(i, 0).get(), number(i, 1).get(), number(i, 2).get());
    if (p.allFinite()) points.push_back(p);
  }
  const Eigen::Vector3d shift = farPart(points, kFar);
  if (shift.isZero()) return std::nullopt;
  for (size_t i = 0; i < ply.count; ++i)
    for (int k = 0; k < 3; ++k) number(i, k).set(number(i, k).get() - shift[k]);
  return ShiftedFile{std::move(contents), shift};
}

}  // namespace

std::optional<ShiftedFile> shiftedNearOrigin(const std::string& file) {
  const std::string extension = extensionOf(file);
  static constexpr std::array<std::string_view, 5> kKnown{".obj", ".stl", ".ply", ".dae", ".ifc"};
  if (std::find(kKnown.begin(), kKnown.end(), extension) == kKnown.end()) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  std::function<bool(const Found&)> each;
  PlyVertices ply;
  double far = kFar;
  bool is_renamed = false;
  if (extension == ".obj") {
    is_renamed = joinObjectNames(&text);
    each = [&](const Found& found) { return triplesAfterWord(text, "v", found); };
  } else if (extension == ".stl") {
    if (text.compare(0, 5, "solid") != 0) return std::nullopt;
    each = [&](const Found& found) { return triplesAfterWord(text, "vertex", found); };
  } else if (extension == ".ifc") {
    const FileUnit unit = statedUnit(file);
    far = kFarIfc / (unit.metres > 0 ? unit.metres : 1);
    each = [&](const Found& found) { return ifcPoints(text, far, found); };
  } else if (extension == ".dae") {
    each = [&](const Found& found) { return colladaPositions(text, found); };
  } else {
    if (!plyVertices(text, &ply)) return std::nullopt;
    if (!ply.ascii) return shiftedBinaryPly(std::move(text), ply);
    each = [&](const Found& found) { return plyPositions(text, ply, found); };
  }
  std::vector<Eigen::Vector3d> points;
  // A part of the vertices must not stay behind.
  const bool is_understood = each([&](const Triple& triple) { points.push_back(valueOf(triple)); });
  const Eigen::Vector3d shift = is_understood ? farPart(points, far) : Eigen::Vector3d::Zero();
  if (!shift.isZero()) return ShiftedFile{rewritten(text, shift, each), shift};
  if (is_renamed) return ShiftedFile{std::move(text), shift};
  return std::nullopt;
}

}  // namespace edge_mcl
