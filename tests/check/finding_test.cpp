#include <gtest/gtest.h>

#include "slipstream/check.h"

namespace slipstream::finding_test {

TEST(Finding, IsOneLineForPeople) {
  const Finding finding{.what = "the bands disagree about the phase",
                        .evidence = {{"agreement", 0.123456}, {"offset in periods", 0.33}},
                        .likely = "frames 0 to 2 are rotated by one",
                        .advice = "try --order 2,0,1,3,4,5"};
  EXPECT_EQ(
      text_of(finding),
      "the bands disagree about the phase (agreement = 0.123, offset in periods = 0.33); likely "
      "frames 0 to 2 are rotated by one; try --order 2,0,1,3,4,5");
  EXPECT_EQ(text_of({.what = "no light"}), "no light");
}

TEST(Finding, RefusesWhereOneIsWrong) {
  EXPECT_FALSE(any_wrong({}));
  const std::vector<Finding> doubtful{{.what = "a"}};
  EXPECT_FALSE(any_wrong(doubtful));
  const std::vector<Finding> wrong{{.what = "a"}, {.gravity = Gravity::wrong, .what = "b"}};
  EXPECT_TRUE(any_wrong(wrong));
}

}  // namespace slipstream::finding_test
