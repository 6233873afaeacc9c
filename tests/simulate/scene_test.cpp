#include "slipstream/scene.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/ray_packet.h"
#include "simulate/sculptures.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"

namespace slipstream::scene_test {

using Vector = Eigen::Vector3d;

Eigen::Isometry3d at(const Vector& position) {
  return Eigen::Isometry3d(Eigen::Translation3d(position));
}

/// A sphere as triangles.
Mesh sphere_mesh(double radius) {
  Mesh mesh;
  append_surface(mesh, 60, 120, [radius](double u, double v) {
    const double longitude = 2 * std::numbers::pi * u, latitude = std::numbers::pi * v;
    return Vector(radius * std::sin(latitude) * std::cos(longitude), radius * std::cos(latitude),
                  radius * std::sin(latitude) * std::sin(longitude));
  });
  return mesh;
}

/// Whether anything other than the surface at `point` blocks `light`.
bool in_shadow(const std::vector<PlacedBody>& bodies, const Vector& point, const Vector& light) {
  LaneVectors directions;
  for (int i = 0; i < packet_rays; ++i) directions.set(i, point - light);
  Lanes limit;
  limit.fill(own_surface);
  block(bodies, light, directions, limit);
  return limit[0] < 0;
}

TEST(Scene, RaysMeetShapesWhereTheyShould) {
  const Ray ray{Vector::Zero(), Vector(0.1, -0.05, 1)};
  const auto depth = [&](const Shape& shape) {
    const Scene scene{Body{.shape = shape, .pose = at({0, 0, 500})}};
    const auto surface = first_surface(placed_at(scene, 0), ray);
    return surface ? surface->distance : std::nan("");
  };
  EXPECT_DOUBLE_EQ(depth(Board{200, 200}), 500);
  EXPECT_TRUE(std::isnan(depth(Board{90, 90})));
  EXPECT_DOUBLE_EQ(depth(Box{Vector(200, 200, 100)}), 450);
  const double sphere = depth(Sphere{100});
  EXPECT_NEAR((sphere * ray.direction - Vector(0, 0, 500)).norm(), 100, 1e-10);
  EXPECT_LT(sphere, 500);
  EXPECT_TRUE(std::isnan(depth(Sphere{40})));
}

TEST(Scene, AMeshOfASphereIsNearlyOne) {
  const auto tree = std::make_shared<const MeshTree>(sphere_mesh(100));
  const Scene mesh{Body{.shape = tree, .pose = at({0, 0, 500})}};
  const Scene exact{Body{.shape = Sphere{100}, .pose = at({0, 0, 500})}};
  int hits = 0;
  for (double u = -0.3; u <= 0.3; u += 0.01) {
    for (double v = -0.3; v <= 0.3; v += 0.01) {
      const Ray ray{Vector::Zero(), Vector(u, v, 1)};
      const auto a = first_surface(placed_at(mesh, 0), ray);
      const auto b = first_surface(placed_at(exact, 0), ray);
      if (!a || !b || b->normal.z() > -0.3) continue;
      ++hits;
      ASSERT_NEAR(a->distance, b->distance, 1.5);
      ASSERT_GT(a->normal.dot(b->normal), 0.98);
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(Scene, TheNearestBodyIsSeenAndShadesTheOthers) {
  const Scene scene{Body{.shape = Board{1000, 1000}, .pose = at({0, 0, 800})},
                    Body{.shape = Sphere{50}, .pose = at({0, 0, 500})}};
  EXPECT_DOUBLE_EQ(first_surface(placed_at(scene, 0), {Vector::Zero(), Vector(0, 0, 1)})->distance,
                   450);
  const Vector light(300, 0, 0);
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  // The shadow of the sphere's centre falls on the board at x = -180.
  EXPECT_TRUE(in_shadow(bodies, {-180, 0, 800}, light));
  EXPECT_FALSE(in_shadow(bodies, {100, 0, 800}, light));
  EXPECT_FALSE(in_shadow(bodies, {0, 0, 450}, light));
}

TEST(Scene, BodiesMoveFromFrameToFrame) {
  const Scene scene{Body{
      .shape = Board{100, 100}, .pose = at({0, 0, 500}), .motion = {.step = Vector(0, 0, -2)}}};
  EXPECT_DOUBLE_EQ(first_surface(placed_at(scene, 3), {Vector::Zero(), Vector(0, 0, 1)})->distance,
                   494);
}

TEST(Scene, BodiesTurnSwingAndBreatheAboutTheirCentre) {
  const Vector centre(0, 0, 500);
  const Motion turning{.turn = {0, std::numbers::pi / 8, 0}, .centre = centre};
  EXPECT_TRUE((turning.at(4) * Vector(10, 5, 500)).isApprox(Vector(0, 5, 490), 1e-12));
  const Motion swinging{.vibration = {Vector(0, 0, 3), 8}};
  EXPECT_TRUE((swinging.at(2) * centre).isApprox(Vector(0, 0, 503), 1e-12));
  EXPECT_TRUE((swinging.at(6) * centre).isApprox(Vector(0, 0, 497), 1e-12));
  const Motion breathing{.breathing = {0.1, 8}, .centre = centre};
  EXPECT_TRUE((breathing.at(2) * Vector(10, 0, 480)).isApprox(Vector(11, 0, 478), 1e-12));

  // All at once, half as fast: what a ray meets are the points of the body, moved.
  Motion all{.step = {2, -1, 3},
             .turn = {0.01, 0.02, 0},
             .vibration = {Vector(0, 1, 0), 5},
             .breathing = {0.05, 7},
             .centre = centre,
             .pace = 0.5};
  const Body box{.shape = Box{{80, 60, 40}}, .pose = at(centre)};
  Scene moving{box};
  moving[0].motion = all;
  for (const double time : {-3.0, 0.0, 2.5, 9.0}) {
    const Ray ray{Vector::Zero(), Vector(0.03, -0.02, 1)};
    const auto met = first_surface(placed_at(moving, time), ray);
    ASSERT_TRUE(met) << time;
    const Vector before = all.at(time).inverse() * met->point;
    const Vector in_box = (before - centre).cwiseAbs().cwiseQuotient(Vector(40, 30, 20));
    EXPECT_NEAR(in_box.maxCoeff(), 1, 1e-9) << time;
    EXPECT_NEAR(met->normal.norm(), 1, 1e-12);
    EXPECT_NEAR((met->point - met->distance * ray.direction).norm(), 0, 1e-9);
  }
}

TEST(Scene, ACarriedPartFollowsItsCarrier) {
  // A forearm that sways by a right angle about the origin carries a hand, which sways by as much
  // about its wrist.
  const double right_angle = std::numbers::pi / 2;
  const Motion arm{.sway = {Vector(0, 0, right_angle), 4}};
  const Motion wrist{.centre = {10, 0, 0},
                     .sway = {Vector(0, 0, right_angle), 4},
                     .carrier = std::make_shared<const Motion>(arm)};
  EXPECT_TRUE((wrist.at(0) * Vector(15, 0, 0)).isApprox(Vector(15, 0, 0), 1e-12));
  EXPECT_TRUE((wrist.at(1) * Vector(10, 0, 0)).isApprox(Vector(0, 10, 0), 1e-12));
  EXPECT_TRUE((wrist.at(1) * Vector(15, 0, 0)).isApprox(Vector(-5, 10, 0), 1e-12));

  // At half the pace, its carrier is slower too.
  Motion slow = wrist;
  slow.pace = 0.5;
  EXPECT_TRUE((slow.at(2) * Vector(15, 0, 0)).isApprox(Vector(-5, 10, 0), 1e-12));
}

TEST(Scene, AMotionMovedWithItsBodyIsTheSameMotion) {
  const Motion arm{.turn = {0.01, 0, 0.02}, .centre = {1, 2, 3}};
  const Motion wrist{.step = {0.1, 0.2, -0.1},
                     .vibration = {Vector(0, 2, 1), 7},
                     .centre = {10, 0, 5},
                     .sway = {Vector(0.3, 0, 0.1), 9},
                     .carrier = std::make_shared<const Motion>(arm)};
  const Eigen::Isometry3d change =
      Eigen::Translation3d(20, -5, 60) * Eigen::AngleAxisd(0.7, Vector(1, 2, -1).normalized());
  const Motion moved = moved_by(change, wrist);
  const Vector point(4, -3, 8);
  for (const double time : {0.0, 1.5, 6.0}) {
    EXPECT_TRUE(
        (moved.at(time) * (change * point)).isApprox(change * (wrist.at(time) * point), 1e-9))
        << time;
  }
}

TEST(Scene, AMotionIsAddedOutsideTheScenesOwn) {
  const Motion arm{.sway = {Vector(0, 0, 0.5), 4}};
  const Motion hand{.carrier = std::make_shared<const Motion>(arm)};
  const Motion step{.step = {0, 0, 2}};
  const Motion both = carried_by(step, hand);
  EXPECT_TRUE((both.at(1) * Vector(5, 0, 0)).isApprox(step.at(1) * (hand.at(1) * Vector(5, 0, 0))));
  EXPECT_TRUE(carried_by(Motion{}, hand).carrier == hand.carrier);
  EXPECT_TRUE(carried_by(step, Motion{}).only_turns() == step.only_turns());
}

TEST(Scene, TellsWhatATurnTakes) {
  Scene scene{Body{.shape = Sphere{5}}, Body{.shape = Board{10, 10}, .fixed = true}};
  EXPECT_FALSE(frames_of_a_turn(scene));
  scene[0].motion.turn = {0, 0, -std::numbers::pi / 180};
  EXPECT_NEAR(frames_of_a_turn(scene).value(), 360, 1e-9);
  scene[0].motion.breathing.amplitude = 0.01;
  EXPECT_FALSE(frames_of_a_turn(scene));
}

TEST(Scene, TexturesSoftEdgesRunThroughWhereTheSharpOnesAre) {
  Image<std::uint8_t> picture({40, 30}, 0);
  for (int row = 0; row < 30; ++row) {
    for (int column = 20; column < 40; ++column) picture(column, row) = 255;
  }
  const Texture soft = picture_texture(picture, 0.1, 0.2, 0.8, 0.25);
  const Texture sharp = picture_texture(picture, 0.1, 0.2, 0.8);
  EXPECT_EQ(sharp({-0.01, 0, 0}), 0.2);
  EXPECT_EQ(sharp({0.01, 0, 0}), 0.8);
  EXPECT_NEAR(soft({0, 0, 0}), 0.5, 1e-6);
  for (const double x : {0.1, 0.25, 0.4}) {
    const double normal_distribution = 0.5 * std::erfc(-x / 0.25 / std::sqrt(2));
    EXPECT_NEAR(soft({x, 0, 0}), 0.2 + 0.6 * normal_distribution, 0.01) << x;
    EXPECT_NEAR(soft({x, 0, 0}) + soft({-x, 0, 0}), 1, 1e-6) << x;
  }
}

TEST(Scene, MeshRefusesWhatIsNoMesh) {
  EXPECT_THROW(MeshTree(Mesh{}), Error);
  EXPECT_THROW(MeshTree(Mesh{{Vector::Zero()}, {{0, 0, 1}}}), Error);
}

TEST(Scene, NamedScenesStandWhereCameraAndProjectorLook) {
  const Scanner scanner = example_scanner();
  const WorkingVolume volume = working_volume(scanner);
  EXPECT_NEAR(volume.centre.z(), 600, 1e-6);
  EXPECT_GT(volume.extent, 200);
  EXPECT_THROW(scene_named("teapot", scanner), Error);
  for (const std::string_view name : scene_names()) {
    const Scene scene = scene_named(name, scanner);
    const Ray ray{Vector::Zero(), Vector(0, 0, 1)};
    EXPECT_TRUE(first_surface(placed_at(scene, 0), ray) || name == "boxes");
  }
}

TEST(Scene, StatueHidesPartsOfItself) {
  const Scene scene{Body{.shape = std::make_shared<const MeshTree>(statue())}};
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  // Along the axis of sight through the ring: ring first, then chest, with space between.
  const auto ring = first_surface(bodies, {Vector(-0.11, -0.16, 5), Vector(0, 0, -1)});
  const auto chest = first_surface(bodies, {Vector(0.02, -0.16, 5), Vector(0, 0, -1)});
  ASSERT_TRUE(ring && chest);
  EXPECT_GT(chest->distance - ring->distance, 0.02);
}

}  // namespace slipstream::scene_test
