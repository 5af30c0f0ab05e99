/// The values that a parameter may have, and the words for them.
#pragma once

#include <cmath>
#include <limits>
#include <string>

namespace edge_mcl {

/// An interval of numbers, or a list of words. The default allows every finite number and every
/// text.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_is_open = false;   ///< `low` itself is not allowed
  bool high_is_open = false;  ///< `high` itself is not allowed
  const char* words = "";     ///< of a text: the allowed ones, separated by `|`; empty: all

  /// Infinite and NaN values are never allowed.
  bool allows(double value) const {
    return std::isfinite(value) && (low_is_open ? value > low : value >= low) &&
           (high_is_open ? value < high : value <= high);
  }
  bool allows(const std::string& value) const {
    return *words == 0 ||
           (value.find('|') == std::string::npos &&
            ("|" + std::string(words) + "|").find("|" + value + "|") != std::string::npos);
  }
  /// Other types have no range.
  template <class Value>
  bool allows(const Value& value) const {
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>)
      return allows(static_cast<double>(value));
    else
      return true;
  }
  /// Completes "must be ...": "positive", "0 to 1", "above 0, up to 1", "tf, topic or none".
  std::string text() const;
};

inline Range anyValue() { return {}; }
inline Range positive() { return {0, std::numeric_limits<double>::infinity(), true, false}; }
inline Range atLeast(double low) { return {low, std::numeric_limits<double>::infinity()}; }
inline Range notNegative() { return atLeast(0); }
/// Both ends are allowed.
inline Range from(double low, double high) { return {low, high}; }
/// Neither end is allowed.
inline Range between(double low, double high) { return {low, high, true, true}; }
/// `low` is not allowed, `high` is.
inline Range above(double low, double high) { return {low, high, true, false}; }
/// `low` is allowed, `high` is not.
inline Range below(double low, double high) { return {low, high, false, true}; }
/// @param words separated by `|`
inline Range oneOf(const char* words) {
  Range range;
  range.words = words;
  return range;
}

}  // namespace edge_mcl
