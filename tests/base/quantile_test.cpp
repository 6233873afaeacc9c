#include "slipstream/base/quantile.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream::quantile_test {

TEST(Quantile, IsTheValueWithThatShareBelow) {
  std::vector<float> values{5, 1, 4, 2, 3};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.25), 2);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 1), 5);
  std::vector<int> even{1, 2, 3, 4}, one{7};
  EXPECT_EQ(quantile(even, 0.5), 3);
  EXPECT_EQ(quantile(one, 0.99), 7);
}

TEST(FiniteValues, LeaveOutWhatIsNotANumber) {
  Image<float> image({2, 2}, 1);
  image(0, 0) = std::numeric_limits<float>::quiet_NaN();
  image(1, 0) = std::numeric_limits<float>::infinity();
  image(1, 1) = 2;
  EXPECT_EQ(finite_values(image), (std::vector<float>{1, 2}));
  EXPECT_EQ(finite_values(image, 2), std::vector<float>{1});
  EXPECT_TRUE(finite_values(Image<double>()).empty());
}

}  // namespace slipstream::quantile_test
