#include "slipstream/codes/axis.h"

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::axis_test {

TEST(Axis, NamesAndLengths) {
  EXPECT_EQ(axis_named("x"), Axis::x);
  EXPECT_EQ(axis_named(name_of(Axis::y)), Axis::y);
  EXPECT_THROW(axis_named("z"), Error);
  EXPECT_EQ(length_along(Axis::x, {1824, 1140}), 1824);
  EXPECT_EQ(length_along(Axis::y, {1824, 1140}), 1140);
  EXPECT_DOUBLE_EQ(coordinate_of_pixel(456, 1824), 0.25);
}

}  // namespace slipstream::axis_test
