// Mouse measurements on clouds of known shape.
#include "view/measuring.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/view/made_up_cloud.h"
#include "view/orbit_camera.h"

namespace slipstream::view::measuring_test {

constexpr Size picture{320, 240};

/// View from the scanner's camera.
glm::mat4 clip_from_the_front() {
  return clip_matrix({.target = in_display_frame({0, 0, 600}), .distance = 600}, picture);
}

glm::vec2 place_of(const glm::vec3& point) {
  return *pixel_of(clip_from_the_front() * glm::vec4(point, 1), picture);
}

TEST(Measuring, PointUnderIsTheNearestToTheEyeOfThoseThere) {
  Cloud cloud = cloud_of(wall({160, 120}, 600));
  cloud.x(5, 5) = 0;
  cloud.y(5, 5) = 0;
  cloud.z(5, 5) = 500;  // in front of the wall
  const CloudOnPicture shown{cloud, nullptr, clip_from_the_front(), picture};
  const auto before = point_under(shown, place_of({0, 0, 500}), 5);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->position.z(), 500);
  const auto beside = point_under(shown, place_of({60, 30, 600}), 5);
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->position.x(), 60, 8);
  EXPECT_EQ(beside->position.z(), 600);
  EXPECT_FALSE(beside->sigma) << "nobody knows it";
}

TEST(Measuring, PointUnderIsNoneWhereNothingIsDrawn) {
  const Cloud nothing({16, 12});
  EXPECT_FALSE(point_under({nothing, nullptr, clip_from_the_front(), picture}, {160, 120}, 20));
}

TEST(Measuring, PointUnderKnowsHowSureItIs) {
  const Cloud cloud = cloud_of(wall({160, 120}, 600));
  Uncertainty sigma(cloud.size());
  for (Image<float>* part : {&sigma.x, &sigma.y, &sigma.z}) {
    std::fill(part->begin(), part->end(), 0.25F);
  }
  const auto point = point_under({cloud, &sigma, clip_from_the_front(), picture}, {160, 120}, 5);
  ASSERT_TRUE(point && point->sigma);
  EXPECT_NE(text_of(*point).find("sigma of Z 0.250 mm"), std::string::npos) << text_of(*point);
}

TEST(Measuring, MeasuredSaysTheDistanceOfTwoPointsAndBeginsAnewWithTheThird) {
  Measured measured;
  add_end(measured, {.position = {0, 0, 600}});
  EXPECT_EQ(measured.ends.size(), 1U);
  add_end(measured, {.position = {30, 40, 600}});
  ASSERT_EQ(measured.lines.size(), 1U);
  EXPECT_EQ(measured.lines[0], "Distance: 50.000 mm");
  add_end(measured, {.position = {1, 2, 603}});
  EXPECT_EQ(measured.ends.size(), 1U);
}

TEST(Measuring, MeasuredSaysThePlaneOfARectangleAndThatItIsNoSphere) {
  const Cloud cloud = cloud_of(wall({160, 120}, 600));
  const auto points = points_between({cloud, nullptr, clip_from_the_front(), picture},
                                     place_of({50, 40, 600}), place_of({-50, -40, 600}));
  EXPECT_GT(points.size(), 300U);
  EXPECT_LT(points.size(), cloud.z.pixel_count() / 10);
  for (const MeasuredPoint& point : points) {
    EXPECT_LE(std::abs(point.position.x()), 50.1);
    EXPECT_LE(std::abs(point.position.y()), 40.1);
  }
  Measured measured;
  fit_shapes(measured, points);
  ASSERT_EQ(measured.lines.size(), 2U);
  EXPECT_EQ(measured.lines[0].find("Plane: rms 0.000 mm"), 0U) << measured.lines[0];
  EXPECT_EQ(measured.lines[1].find("No sphere: "), 0U) << measured.lines[1];
  fit_shapes(measured, {});
  EXPECT_EQ(measured.lines[0].find("No plane: "), 0U) << measured.lines[0];
}

}  // namespace slipstream::view::measuring_test
