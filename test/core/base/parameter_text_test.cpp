#include "edge_mcl/core/base/parameter_text.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace edge_mcl::parameter_text {
namespace {

/// Reads a value from text. The test fails where the text is refused.
template <class Value>
Value read(const std::string& text) {
  Value value{};
  EXPECT_TRUE(fromText(text, &value)) << "'" << text << "'";
  return value;
}

/// Every text must be refused. A value that was there before must stay as it was.
template <class Value>
void expectRefused(const Value& before, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    Value value = before;
    EXPECT_FALSE(fromText(text, &value)) << "'" << text << "'";
    EXPECT_EQ(value, before) << "'" << text << "'";
  }
}

/// The values have at most 12 digits, which is the precision of the text.
TEST(ParameterText, NumbersComeBackFromTheirTexts) {
  for (const double value : {0.0, 0.1, -2.5, 1.0 / 1024, 1e-300, 1.7e308, 123456789012.0, 1e100})
    EXPECT_EQ(read<double>(toText(value)), value);
  for (const int value :
       {0, -1, 42, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()})
    EXPECT_EQ(read<int>(toText(value)), value);
  for (const uint64_t value : {uint64_t{0}, std::numeric_limits<uint64_t>::max()})
    EXPECT_EQ(read<uint64_t>(toText(value)), value);
}

TEST(ParameterText, NumbersAreWrittenAsPeopleWriteThem) {
  EXPECT_EQ(toText(0.1), "0.1");
  EXPECT_EQ(toText(3.0), "3");
  EXPECT_EQ(toText(0.001), "0.001");
  EXPECT_EQ(toText(-7), "-7");
  EXPECT_EQ(toText(uint64_t{18446744073709551615u}), "18446744073709551615");
}

TEST(ParameterText, NumbersAreReadInTheUsualForms) {
  EXPECT_EQ(read<double>("1e-3"), 0.001);
  EXPECT_EQ(read<double>("-.5"), -0.5);
  EXPECT_EQ(read<double>(" 2.5 "), 2.5);
  EXPECT_EQ(read<double>("7"), 7);
  EXPECT_EQ(read<int>("-12"), -12);
  EXPECT_EQ(read<uint64_t>("12"), 12u);
}

TEST(ParameterText, WhatIsNotOneFiniteNumberIsRefused) {
  expectRefused(1.25,
                {"", " ", "big", "1.5m", "1 2", "1,5", "nan", "inf", "-inf", "1e999", "0x10", "-"});
}

TEST(ParameterText, WhatIsNotOneWholeNumberIsRefused) {
  expectRefused(5, {"", "2.5", "1e3", "three", "1 2", "2147483648", "-2147483649", "true"});
  expectRefused(uint64_t{5}, {"", "-1", " -1", "2.5", "18446744073709551616", "1 2"});
}

TEST(ParameterText, SwitchesHaveThreePairsOfWords) {
  for (const char* text : {"true", "1", "yes"}) EXPECT_TRUE(read<bool>(text));
  for (const char* text : {"false", "0", "no"}) EXPECT_FALSE(read<bool>(text));
  for (const bool value : {true, false}) EXPECT_EQ(read<bool>(toText(value)), value);
  expectRefused(true, {"", "2", "of", "true ", "yess"});
  expectRefused(false, {"", "2", "of", "true ", "yess"});
}

TEST(ParameterText, ATextIsTakenAsItIs) {
  for (const char* text : {"", "two words", " space ", "a|b"}) {
    EXPECT_EQ(read<std::string>(text), text);
    EXPECT_EQ(toText(std::string(text)), text);
  }
}

/// Every choice has one word. The word is read back as the same choice, and typeName() names it.
template <class Choice>
void expectWords(const std::vector<std::pair<Choice, std::string>>& words) {
  for (const auto& [choice, word] : words) {
    EXPECT_EQ(toText(choice), word);
    EXPECT_EQ(read<Choice>(word), choice);
    EXPECT_NE(std::string(typeName(choice)).find(word), std::string::npos) << word;
  }
  expectRefused(words.back().first, {"", "0", "other", words.front().second + " "});
}

TEST(ParameterText, EveryChoiceHasItsWord) {
  expectWords<BackendChoice>({{BackendChoice::kAuto, "auto"},
                              {BackendChoice::kCpu, "cpu"},
                              {BackendChoice::kCuda, "cuda"}});
  expectWords<LikelihoodModel>(
      {{LikelihoodModel::kPaper, "paper"}, {LikelihoodModel::kRobust, "robust"}});
  expectWords<Cues>({{Cues::kEdges, "edges"}, {Cues::kDepth, "depth"}, {Cues::kBoth, "both"}});
}

TEST(ParameterText, ARangeIsTheNumbersOrTheWordsThatAreAllowed) {
  EXPECT_EQ(rangeText(0.5, from(0, 1)), "0 to 1");
  EXPECT_EQ(rangeText(3, atLeast(1)), "at least 1");
  EXPECT_EQ(rangeText(std::string("tf"), oneOf("tf|none")), "tf or none");
  EXPECT_EQ(rangeText(std::string(), anyValue()), "a text");
  EXPECT_EQ(rangeText(true, anyValue()), "true or false");
  EXPECT_EQ(rangeText(Cues::kBoth, anyValue()), "edges, depth or both");
}

}  // namespace
}  // namespace edge_mcl::parameter_text
