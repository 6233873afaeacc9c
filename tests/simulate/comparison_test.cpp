// Clouds of the bench world err as their sigma says, whatever the scene and the strategy.
#include "simulate/comparison.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::comparison_test {

std::vector<Sequence> all_sequences(const Scanner& scanner) {
  std::vector<Sequence> sequences;
  for (const Strategy& strategy : strategies_to_compare()) {
    sequences.push_back({.strategy = strategy, .projector = scanner.projector.size});
  }
  return sequences;
}

class ComparisonBenchWorld : public testing::TestWithParam<std::string_view> {};

TEST_P(ComparisonBenchWorld, ErrsAsSigmaSays) {
  const Scanner scanner = example_scanner();
  const VirtualWorld world{scanner, scene_named(GetParam(), scanner), photometry_named("bench")};
  const std::vector<Sequence> sequences = all_sequences(scanner);
  const std::vector<ComparedSequence> all = compare(world, sequences);
  for (std::size_t i = 0; i < all.size(); ++i) {
    SCOPED_TRACE(label_of(sequences[i].strategy));
    const CloudErrors& errors = all[i].errors;
    EXPECT_GT(errors.points, 30000U);
    EXPECT_GE(errors.normalised_rms, 0.9);
    EXPECT_LE(errors.normalised_rms, 1.2);
    EXPECT_LE(errors.beyond_5, 0.003);
    EXPECT_LE(errors.flying, 0.001);
    EXPECT_LE(errors.wrong_order, 0.001);
  }
}

/// Sigma does not know of motion.
std::vector<std::string_view> still_scene_names() {
  std::vector<std::string_view> names = scene_names();
  std::erase_if(
      names, [](std::string_view name) { return is_moving(scene_named(name, example_scanner())); });
  return names;
}

INSTANTIATE_TEST_SUITE_P(Scenes, ComparisonBenchWorld, testing::ValuesIn(still_scene_names()),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(Comparison, GivesTwiceTheFramesHalfTheLight) {
  const Scanner scanner = example_scanner({160, 120});
  const VirtualWorld world{scanner, scene_named("board", scanner),
                           photometry_named("ideal,sensor-noise")};
  // Twelve frames at the light of twelve threes: shot noise leaves the mean of as much light.
  const std::vector<ComparedSequence> all = compare(
      world,
      {{.strategy = make_strategy("pmp", {{"steps", 6}}), .projector = scanner.projector.size},
       {.strategy = make_strategy("pmp", {{"steps", 12}}), .projector = scanner.projector.size}},
      {.clean = CleanSettings::none()});
  EXPECT_NEAR(all[1].repeatability / all[0].repeatability, 1, 0.15);
}

const Sequence sequence{.projector = example_scanner().projector.size};

/// The errors of a cloud of 8000 points near the truth. Every fourth has `depth_of_every_fourth`.
CloudErrors errors_of(const Image<double>& depth_of_every_fourth, const VirtualScan& truth,
                      const VirtualWorld& world) {
  const Scanner& scanner = world.scanner;
  Cloud cloud(scanner.camera.size);
  Uncertainty sigma(scanner.camera.size);
  Image<float> coordinate(scanner.camera.size);
  int points = 0;
  for (int row = 20; row < 100; ++row) {
    for (int column = 20; column < 120; ++column) {
      const double z =
          ++points % 4 == 0 ? depth_of_every_fourth(column, row) : truth.depth(column, row) + 0.1;
      const Eigen::Vector3d point = z * ray_through(scanner.camera, {column, row});
      cloud.x(column, row) = static_cast<float>(point.x());
      cloud.y(column, row) = static_cast<float>(point.y());
      cloud.z(column, row) = static_cast<float>(z);
      cloud.validity(column, row) = Validity::valid;
      sigma.z(column, row) = 0.1F;
      coordinate(column, row) = static_cast<float>(truth.coordinate(column, row));
    }
  }
  return cloud_errors(cloud, sigma, coordinate, sequence.strategy.layout(), truth, world);
}

TEST(Comparison, CountsWhatIsOffEverySurface) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = scene_named("board", scanner);
  const VirtualScan truth = take_scan(scanner, scene, pattern_set(sequence));
  Image<double> before_the_board = truth.depth;
  for (double& depth : before_the_board) depth -= 20;
  const CloudErrors errors = errors_of(before_the_board, truth, {scanner, scene});
  EXPECT_EQ(errors.points, 8000U);
  EXPECT_DOUBLE_EQ(errors.flying, 0.25);
  EXPECT_DOUBLE_EQ(errors.beyond_5, 0.25);
  EXPECT_EQ(errors.wrong_order, 0);
  EXPECT_NEAR(errors.rms, 0.1, 1e-4);
  EXPECT_NEAR(errors.normalised_rms, 1, 1e-3);
}

TEST(Comparison, FindsSurfacesOfAMovingSceneWhereTheirTruthIs) {
  const Scanner scanner = example_scanner({160, 120});
  Scene scene = scene_named("board", scanner);
  const VirtualScan first = take_scan(scanner, scene, pattern_set(sequence));
  for (Body& body : scene) body.motion.step = {0, 0, 8};
  const VirtualScan truth = take_scan(scanner, scene, pattern_set(sequence));
  EXPECT_EQ(truth.truth_time, 1) << "of three frames";
  // The board has left the place that it has in the first frame.
  const CloudErrors errors = errors_of(first.depth, truth, {scanner, scene});
  EXPECT_EQ(errors.points, 8000U);
  EXPECT_DOUBLE_EQ(errors.flying, 0.25);
}

}  // namespace slipstream::comparison_test
