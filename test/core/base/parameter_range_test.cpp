#include "edge_mcl/core/base/parameter_range.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

TEST(Range, EndsAreAllowedOrNot) {
  EXPECT_TRUE(from(0, 1).allows(0.0) && from(0, 1).allows(1.0));
  EXPECT_FALSE(from(0, 1).allows(-1e-9) || from(0, 1).allows(1 + 1e-9));
  EXPECT_FALSE(between(0, 1).allows(0.0) || between(0, 1).allows(1.0));
  EXPECT_FALSE(above(0, 1).allows(0.0));
  EXPECT_TRUE(above(0, 1).allows(1.0));
  EXPECT_TRUE(below(0, 1).allows(0.0));
  EXPECT_FALSE(below(0, 1).allows(1.0));
  EXPECT_FALSE(positive().allows(0.0));
  EXPECT_TRUE(notNegative().allows(0));
  EXPECT_FALSE(atLeast(20).allows(19));
}

TEST(Range, NumbersMustBeFinite) {
  for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_FALSE(anyValue().allows(bad));
  EXPECT_TRUE(anyValue().allows(-1e300));
}

TEST(Range, TextsAreOneOfTheWords) {
  const Range range = oneOf("tf|topic|none");
  EXPECT_TRUE(range.allows(std::string("tf")) && range.allows(std::string("none")));
  for (const char* bad : {"", "t", "topi", "tf|topic", "|"})
    EXPECT_FALSE(range.allows(std::string(bad))) << bad;
  EXPECT_TRUE(anyValue().allows(std::string("anything|else")));
  EXPECT_TRUE(anyValue().allows(true));
}

TEST(Range, HasWords) {
  EXPECT_EQ(positive().text(), "positive");
  EXPECT_EQ(notNegative().text(), "zero or more");
  EXPECT_EQ(atLeast(20).text(), "at least 20");
  EXPECT_EQ(from(0, 0.5).text(), "0 to 0.5");
  EXPECT_EQ(between(0, 180).text(), "between 0 and 180");
  EXPECT_EQ(above(0, 5).text(), "above 0, up to 5");
  EXPECT_EQ(below(0, 1).text(), "0 up to, not including, 1");
  EXPECT_EQ(anyValue().text(), "a number");
  EXPECT_EQ(oneOf("tf|topic|none").text(), "tf, topic or none");
}

}  // namespace
}  // namespace edge_mcl
