#include "edge_mcl/core/base/parameter_struct.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

struct Example {
  double length = 1;
  int count = 2;
  bool on = false;
  std::string colour = "red";

  template <class Visitor>
  void visit(Visitor&& v) {
    v("length", length, "m", positive(), "a length");
    v("count", count, "", from(1, 3), "a number of things");
    v("on", on, "", anyValue(), "a switch");
    v("colour", colour, "", oneOf("red|blue"), "a colour");
  }
  std::vector<std::string> faults() const {
    if (on && count == 3) return {"three cannot be on"};
    return {};
  }
};

TEST(ParameterStruct, IsSetByName) {
  Example e;
  setParameter("length", "2.5", &e);
  setParameter("on", "yes", &e);
  EXPECT_EQ(e.length, 2.5);
  EXPECT_TRUE(e.on);
  EXPECT_EQ(trySetParameter("width", "1", &e), std::nullopt);
  EXPECT_EQ(trySetParameter("count", "2", &e), "");
  EXPECT_EQ(trySetParameter("count", "2.5", &e), "parameter 'count': '2.5' is not a whole number");
  EXPECT_EQ(e.count, 2);  // a bad value changes nothing
  try {
    setParameter("lenght", "1", &e);
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_STREQ(error.what(), "unknown parameter 'lenght' (nearest: 'length')");
  }
}

TEST(ParameterStruct, FaultsAreThoseOfRangesAndOfTheStruct) {
  Example e;
  EXPECT_TRUE(parameterFaults(e).empty());
  e.length = 0;
  e.count = 3;
  e.on = true;
  e.colour = "green";
  EXPECT_EQ(parameterFaults(e),
            (std::vector<std::string>{"length = 0 must be positive",
                                      "colour = green must be red or blue", "three cannot be on"}));
  EXPECT_THROW(throwFaults(parameterFaults(e)), ParameterError);
  EXPECT_NO_THROW(throwFaults({}));
}

TEST(ParameterStruct, IsDescribedInItsOrder) {
  const std::vector<ParameterDescription> list = describeParameters(Example());
  ASSERT_EQ(list.size(), 4u);
  EXPECT_EQ(list[0].name, "length");
  EXPECT_EQ(list[0].unit, "m");
  EXPECT_EQ(list[0].value, "1");
  EXPECT_EQ(list[0].range, "positive");
  EXPECT_EQ(list[2].range, "true or false");
  EXPECT_EQ(list[3].range, "red or blue");
}

}  // namespace
}  // namespace edge_mcl
