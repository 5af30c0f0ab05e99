/// Parameter values as text and back; one overload for every type that a parameter may have.
#pragma once

#include <cmath>
#include <sstream>
#include <string>
#include <type_traits>

#include "edge_mcl/core/base/parameter_range.h"
#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl::parameter_text {

inline std::string toText(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}
inline std::string toText(int value) { return std::to_string(value); }
inline std::string toText(uint64_t value) { return std::to_string(value); }
inline std::string toText(const std::string& value) { return value; }
inline std::string toText(bool value) { return value ? "true" : "false"; }
inline std::string toText(BackendChoice value) {
  return value == BackendChoice::kAuto ? "auto" : value == BackendChoice::kCpu ? "cpu" : "cuda";
}
inline std::string toText(LikelihoodModel value) {
  return value == LikelihoodModel::kPaper ? "paper" : "robust";
}
inline std::string toText(Cues value) {
  return value == Cues::kEdges ? "edges" : value == Cues::kDepth ? "depth" : "both";
}

template <class Number>
bool parseNumber(const std::string& text, Number* value) {
  std::istringstream in(text);
  Number parsed{};
  if (std::is_unsigned<Number>::value && text.find('-') != std::string::npos) return false;
  if (!(in >> parsed)) return false;
  in >> std::ws;
  if (!in.eof()) return false;
  *value = parsed;
  return true;
}
inline bool fromText(const std::string& text, double* value) {
  return parseNumber(text, value) && std::isfinite(*value);
}
inline bool fromText(const std::string& text, int* value) { return parseNumber(text, value); }
inline bool fromText(const std::string& text, uint64_t* value) { return parseNumber(text, value); }
inline bool fromText(const std::string& text, std::string* value) { return *value = text, true; }
inline bool fromText(const std::string& text, bool* value) {
  if (text == "true" || text == "1" || text == "yes") return *value = true, true;
  if (text == "false" || text == "0" || text == "no") return *value = false, true;
  return false;
}
inline bool fromText(const std::string& text, BackendChoice* value) {
  if (text == "auto") return *value = BackendChoice::kAuto, true;
  if (text == "cpu") return *value = BackendChoice::kCpu, true;
  if (text == "cuda") return *value = BackendChoice::kCuda, true;
  return false;
}

inline bool fromText(const std::string& text, LikelihoodModel* value) {
  if (text == "paper") return *value = LikelihoodModel::kPaper, true;
  if (text == "robust") return *value = LikelihoodModel::kRobust, true;
  return false;
}
inline bool fromText(const std::string& text, Cues* value) {
  if (text == "edges") return *value = Cues::kEdges, true;
  if (text == "depth") return *value = Cues::kDepth, true;
  if (text == "both") return *value = Cues::kBoth, true;
  return false;
}

inline const char* typeName(double) { return "a number"; }
inline const char* typeName(int) { return "a whole number"; }
inline const char* typeName(uint64_t) { return "a whole number"; }
inline const char* typeName(const std::string&) { return "a text"; }
inline const char* typeName(bool) { return "true or false"; }
inline const char* typeName(BackendChoice) { return "auto, cpu or cuda"; }
inline const char* typeName(Cues) { return "edges, depth or both"; }
inline const char* typeName(LikelihoodModel) { return "paper or robust"; }

/// What may stand there, for tables: the range of a number or the words that are allowed.
template <class Value>
std::string rangeText(const Value& value, const Range& range) {
  constexpr bool is_number = std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>;
  if constexpr (is_number) return range.text();
  if (*range.words != 0) return range.text();
  return typeName(value);
}

}  // namespace edge_mcl::parameter_text
