// Scenes on the virtual turntable. Tier: every change.
#include "simulate/turned_scene.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"

namespace slipstream::turned_scene_test {

TEST(TurnedScene, MovesAsTheTurnedObject) {
  constexpr double angle = 0.7;
  const Scanner scanner = example_scanner({80, 60});
  Scene hand = scene_named("hand", scanner);
  const Scene turned = turned_scene(hand, scanner, angle);
  std::erase_if(hand, [](const Body& body) { return body.fixed; });
  ASSERT_EQ(turned.size(), hand.size());

  const TurnAxis axis = turntable_axis(scanner);
  const Eigen::Isometry3d turn = Eigen::Translation3d(axis.point) *
                                 Eigen::AngleAxisd(angle, axis.direction) *
                                 Eigen::Translation3d(-axis.point);

  // The fingers bend in the turned hand as in the other.
  for (std::size_t i = 0; i < hand.size(); ++i) {
    const Eigen::Vector3d place(10, 20, 5);
    for (const double time : {0.0, 15.0, 60.0}) {
      const Eigen::Vector3d wanted = turn * (hand[i].motion.at(time) * (hand[i].pose * place));
      const Eigen::Vector3d found = turned[i].motion.at(time) * (turned[i].pose * place);
      EXPECT_LT((found - wanted).norm(), 1e-9) << i << " at " << time;
    }
  }
}

TEST(TurnedScene, LeavesOutWhatIsFixed) {
  const Scanner scanner = example_scanner({80, 60});
  Scene scene(2, Body{.shape = Sphere{50}});
  scene[1].fixed = true;
  EXPECT_EQ(turned_scene(scene, scanner, 0.5).size(), 1U);
}

}  // namespace slipstream::turned_scene_test
