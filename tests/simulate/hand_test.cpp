#include "simulate/hand.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"

namespace slipstream::hand_test {

using Vector = Eigen::Vector3d;

TEST(Hand, RepeatsAfterItsPeriod) {
  const Scene scene = hand(200, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 600)));
  EXPECT_TRUE(is_moving(scene));
  EXPECT_EQ(frames_of_a_sway(scene), hand_period);
  for (const Body& body : scene) {
    const Vector point = body.pose * Vector(10, 20, 5);
    EXPECT_LT((body.motion.at(hand_period + 7) * point - body.motion.at(7) * point).norm(), 1e-9);
  }
}

TEST(Hand, PhalangesStayJoinedWhileTheyBend) {
  // A joint lies on the parts on both sides of it, so both must move it to the same place.
  const Scene scene = hand(200, Eigen::Isometry3d::Identity());
  int joints = 0;
  for (const Body& body : scene) {
    if (!body.motion.carrier) continue;
    ++joints;
    for (const double time : {-60.0, 15.0, 60.0}) {
      const Vector by_part = body.motion.at(time) * body.motion.centre;
      const Vector by_carrier = body.motion.carrier->at(time) * body.motion.centre;
      EXPECT_LT((by_part - by_carrier).norm(), 1e-9) << joints << " at " << time;
    }
  }
  EXPECT_EQ(joints, 14);
}

/// Share of the pixels of a small picture that see the scene.
double seen_share(const char* name) {
  const Scanner scanner = example_scanner({80, 60});
  const Scene scene = scene_named(name, scanner);
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  int seen = 0;
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 80; ++column) {
      const Ray ray{Vector::Zero(), Vector((column - 40) / 104.0, (row - 30) / 104.0, 1)};
      if (first_surface(bodies, ray)) ++seen;
    }
  }
  return seen / 4800.0;
}

TEST(Hand, NamedScenesFillTheView) {
  EXPECT_GT(seen_share("hand"), 0.2);
  EXPECT_GT(seen_share("angel"), 0.15);
  EXPECT_GT(seen_share("fish"), 0.9);
}

}  // namespace slipstream::hand_test
