/// Checks the errors that code throws.
#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

namespace edge_mcl::test {

/// Text of the error that an action throws. The test fails when the action throws no error, or an
/// error that is not of the given type.
template <class Expected, class Action>
std::string errorText(Action&& action) {
  try {
    action();
    ADD_FAILURE() << "no error was thrown";
  } catch (const std::exception& e) {
    if (dynamic_cast<const Expected*>(&e) != nullptr) return e.what();
    ADD_FAILURE() << "an error of another type was thrown: " << e.what();
  }
  return {};
}

/// Whether a text contains a piece, for EXPECT_PRED2.
inline bool contains(const std::string& text, const std::string& piece) {
  return text.find(piece) != std::string::npos;
}

/// Expects that an action throws an error of the given type, and that its text contains a piece.
template <class Expected, class Action>
void expectError(const std::string& piece, Action&& action) {
  EXPECT_PRED2(contains, errorText<Expected>(action), piece);
}

}  // namespace edge_mcl::test
