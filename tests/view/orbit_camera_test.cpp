#include "view/orbit_camera.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace slipstream::view::orbit_camera_test {

constexpr Size picture{640, 480};
constexpr float tolerance = 2e-3F;

glm::vec2 seen(const OrbitCamera& camera, const glm::vec3& point) {
  return pixel_of(clip_matrix(camera, picture) * glm::vec4(point, 1), picture).value();
}

/// Looks at (0, 0, 600) in the scanner's frame from the scanner's camera.
OrbitCamera straight() {
  return {.target = in_display_frame({0, 0, 600}), .distance = 600};
}

TEST(OrbitCamera, SeesTheTargetInTheMiddle) {
  const glm::vec2 middle = seen(straight(), {0, 0, 600});
  EXPECT_NEAR(middle.x, 319.5F, tolerance);
  EXPECT_NEAR(middle.y, 239.5F, tolerance);
}

TEST(OrbitCamera, ShowsAKnownPointWhereThePinholeFormulaPutsIt) {
  const OrbitCamera camera = straight();
  const glm::vec3 point(60, -45, 700);  // right of and above the axis: Y is down
  const float focal = 240 / std::tan(camera.field_of_view / 2);
  EXPECT_NEAR(pixels_per_slope(camera, picture), focal, tolerance);
  const glm::vec2 pixel = seen(camera, point);
  EXPECT_NEAR(pixel.x, 319.5F + focal * point.x / point.z, tolerance);
  EXPECT_NEAR(pixel.y, 239.5F + focal * point.y / point.z, tolerance);
}

TEST(OrbitCamera, DoesNotShowWhatIsBehindTheEye) {
  const OrbitCamera camera = straight();
  EXPECT_FALSE(
      pixel_of(clip_matrix(camera, picture) * glm::vec4(0, 0, -10, 1), picture).has_value());
}

TEST(OrbitCamera, KeepsTargetAndDistanceWhenTurned) {
  const OrbitCamera turned = orbited(straight(), {0.2F, 0.1F});
  const glm::vec2 middle = seen(turned, {0, 0, 600});
  EXPECT_NEAR(middle.x, 319.5F, tolerance);
  EXPECT_NEAR(middle.y, 239.5F, tolerance);
  const glm::vec4 at_eye = view_matrix(turned) * glm::vec4(turned.target, 1);
  EXPECT_NEAR(-at_eye.z, 600, 0.01F);
}

TEST(OrbitCamera, FollowsTheMouseWhenTurned) {
  // Points nearer than the target follow the drag.
  const glm::vec3 near_point(0, 0, 500);
  const glm::vec2 before = seen(straight(), near_point);
  EXPECT_GT(seen(orbited(straight(), {0.1F, 0}), near_point).x, before.x + 1);
  EXPECT_GT(seen(orbited(straight(), {0, 0.1F}), near_point).y, before.y + 1);
}

TEST(OrbitCamera, DoesNotTurnOverTheTop) {
  const OrbitCamera camera = orbited(straight(), {0, 100});
  EXPECT_LT(camera.elevation, 1.5708F);
  EXPECT_TRUE(std::isfinite(seen(camera, {0, 0, 590}).y));
}

TEST(OrbitCamera, TakesTheTargetAlongWhenPanned) {
  const OrbitCamera turned = orbited(straight(), {0.15F, -0.1F});
  const glm::vec2 shift(0.25F, -0.125F);  // in heights: 120 pixels right, 60 up
  const glm::vec2 pixel = seen(panned(turned, shift), {0, 0, 600});
  EXPECT_NEAR(pixel.x, 319.5F + 120, 0.05F);
  EXPECT_NEAR(pixel.y, 239.5F - 60, 0.05F);
}

TEST(OrbitCamera, ComesNearerAndBack) {
  const OrbitCamera nearer = zoomed(straight(), 3);
  EXPECT_LT(nearer.distance, 600);
  EXPECT_NEAR(zoomed(nearer, -3).distance, 600, 1e-3F);
  EXPECT_GT(zoomed(straight(), 1000).distance, 0);
}

TEST(OrbitCamera, FitsABoxIntoAnyPicture) {
  const Box box{{-80, -60, 500}, {80, 60, 640}};
  for (const Size size : {Size{640, 480}, Size{1280, 320}, Size{300, 900}, Size{1, 1}}) {
    const OrbitCamera camera = fitted({.azimuth = -0.4F, .elevation = 0.2F}, box, size);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 point((corner & 1) != 0 ? box.low.x : box.high.x,
                            (corner & 2) != 0 ? box.low.y : box.high.y,
                            (corner & 4) != 0 ? box.low.z : box.high.z);
      const glm::vec4 clip = clip_matrix(camera, size) * glm::vec4(point, 1);
      EXPECT_LT(std::abs(clip.x), clip.w);
      EXPECT_LT(std::abs(clip.y), clip.w);
      EXPECT_LT(std::abs(clip.z), clip.w);
    }
  }
}

TEST(OrbitCamera, MirrorsInThePlane) {
  const OrbitCamera camera = orbited(straight(), {0.1F, 0.05F});
  const float floor = 80;
  const glm::mat4 mirrored = mirrored_clip_matrix(camera, picture, floor);
  const glm::vec3 point(20, 30, 610), image(20, 130, 610);
  const glm::vec2 expected = seen(camera, image);
  const glm::vec2 pixel = pixel_of(mirrored * glm::vec4(point, 1), picture).value();
  EXPECT_NEAR(pixel.x, expected.x, tolerance);
  EXPECT_NEAR(pixel.y, expected.y, tolerance);
  // Points in the plane do not move.
  const glm::vec3 on_floor(-15, floor, 580);
  EXPECT_NEAR(pixel_of(mirrored * glm::vec4(on_floor, 1), picture)->y, seen(camera, on_floor).y,
              tolerance);
}

}  // namespace slipstream::view::orbit_camera_test
