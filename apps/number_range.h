/// Checks the numbers of options.
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <sstream>
#include <string>

namespace edge_mcl {

/// Requires a number from `low` to `high`. The checks of CLI11 let "nan" pass.
inline CLI::Validator numberFrom(double low, double high) {
  std::ostringstream range;
  range << low << " to " << high;
  return {[low, high, text = range.str()](const std::string& word) -> std::string {
            double value = 0;
            const auto [end, error] =
                std::from_chars(word.data(), word.data() + word.size(), value);
            const bool is_good = error == std::errc() && end == word.data() + word.size() &&
                                 value >= low && value <= high;
            return is_good ? "" : "'" + word + "' is not a number from " + text;
          },
          range.str()};
}

}  // namespace edge_mcl
