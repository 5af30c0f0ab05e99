#include "edge_mcl/core/base/parameter_range.h"

#include <sstream>

namespace edge_mcl {

namespace {

std::string numberText(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

/// "a|b|c" as "a, b or c".
std::string listed(const std::string& words) {
  std::string text;
  size_t begin = 0;
  while (true) {
    const size_t end = words.find('|', begin);
    const std::string word = words.substr(begin, end - begin);
    const bool is_last = end == std::string::npos;
    text += (text.empty() ? "" : is_last ? " or " : ", ") + word;
    if (is_last) return text;
    begin = end + 1;
  }
}

}  // namespace

std::string Range::text() const {
  if (*words != 0) return listed(words);
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  const std::string l = numberText(low), h = numberText(high);
  if (!has_low && !has_high) return "a number";
  if (!has_high && low == 0) return low_is_open ? "positive" : "zero or more";
  if (!has_high) return (low_is_open ? "above " : "at least ") + l;
  if (!has_low) return (high_is_open ? "below " : "at most ") + h;
  if (low_is_open && high_is_open) return "between " + l + " and " + h;
  if (low_is_open) return "above " + l + ", up to " + h;
  if (high_is_open) return l + " up to, not including, " + h;
  return l + " to " + h;
}

}  // namespace edge_mcl
