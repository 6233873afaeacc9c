#include "geometry/map_form.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "slipstream/error.h"

namespace slipstream::map_form_test {

TEST(MapForm, HasTheNameThatItIsReadFrom) {
  for (const std::string name : {"coordinate", "pixels", "phase:16", "phase:2.5", "periods:7"}) {
    EXPECT_EQ(name_of(map_form_named(name)), name);
  }
}

TEST(MapForm, NeedsPeriodsWhereTheyCount) {
  for (const std::string name : {"", "depth", "phase", "phase:", "phase:0", "phase:x", "phase:-3",
                                 "periods", "pixels:3", "coordinate:"}) {
    EXPECT_THROW((void)map_form_named(name), Error) << name;
  }
}

/// The coordinate of one value.
double coordinate_of(double value, const MapForm& form) {
  return coordinates_of_map(Image<double>({1, 1}, value), form, 1280)(0, 0);
}

TEST(MapForm, ReadsCoordinates) {
  const double pi = std::numbers::pi;
  EXPECT_EQ(coordinate_of(0.25, {}), 0.25);
  EXPECT_EQ(coordinate_of(320, {.unit = MapUnit::pixels}), 0.25);
  EXPECT_DOUBLE_EQ(coordinate_of(8 * pi, {.unit = MapUnit::phase, .periods = 16}), 0.25);
  EXPECT_EQ(coordinate_of(4, {.unit = MapUnit::periods, .periods = 16}), 0.25);

  // At the edge of the field the value is the origin.
  EXPECT_DOUBLE_EQ(coordinate_of(7 * pi, {.unit = MapUnit::phase, .periods = 16, .origin = -pi}),
                   0.25);
  EXPECT_EQ(coordinate_of(-320, {.unit = MapUnit::pixels, .origin = -640}), 0.25);
}

TEST(MapForm, ReadsValuesThatFall) {
  EXPECT_EQ(coordinate_of(0.75, {.backwards = true}), 0.25);
  EXPECT_EQ(coordinate_of(1279 - 320, {.unit = MapUnit::pixels, .backwards = true}), 0.25);

  const MapForm from_0{.unit = MapUnit::periods, .periods = 16, .origin = 0, .backwards = true};
  EXPECT_EQ(coordinate_of(-4, from_0), 0.25);
}

/// A phase of 4 periods over 128 columns, in turns of that many periods.
Image<double> phase_in_turns(double periods) {
  Image<double> map({128, 16});
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    map(column, row) = two_pi * std::fmod(column / 32.0, periods);
  });
  return map;
}

TEST(MapForm, RefusesAWrappedPhase) {
  const MapForm form{.unit = MapUnit::phase, .periods = 16};
  EXPECT_THROW((void)coordinates_of_map(phase_in_turns(1), form, 1280), Error);
  EXPECT_NO_THROW((void)coordinates_of_map(phase_in_turns(4), form, 1280));

  // A single period is not wrapped: the check of maps sees that its number is another.
  Image<double> single = phase_in_turns(4);
  for (double& value : single) value /= 4;
  EXPECT_NO_THROW((void)coordinates_of_map(single, form, 1280));
}

TEST(MapForm, NeedsAValidValue) {
  EXPECT_THROW((void)coordinate_of(nan, {}), Error);
}

}  // namespace slipstream::map_form_test
