// What a scan says of its own depth noise, against the depth noise of virtual scans.
#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "codes/predicted_variance.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::uncertainty_test {

constexpr PatternLight light{.alpha_p = 200, .beta_p = 40};
const Photometry photometry{.ambient = 4, .noise_variance = 1.55, .bits = 8};

/// RMS of the errors of X, Y, Z and y over their predicted standard deviations.
struct Normalised {
  double x = 0, y = 0, z = 0, coordinate = 0, points = 0;
};

Normalised normalised_errors(const Strategy& strategy, double alpha, EngineKind kind) {
  Scanner scanner = example_scanner({200, 150});
  Scene board = scene_named("board", scanner);
  board.front().texture = uniform_texture(alpha);
  const VirtualScan scan =
      take_scan(scanner, board, pattern_set(strategy, Axis::x, light), photometry);
  scanner.photometry = {.ambient = photometry.ambient,
                        .noise_variance = photometry.noise_variance + quantisation_variance};
  Engine engine(scanner, {.strategy = strategy, .light = light},
                {.engine = kind, .minimum_modulation = 3});
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, scan.frames);

  Normalised sum;
  const auto square = [](double x) { return x * x; };
  for (int row = 0; row < scan.depth.height(); ++row) {
    for (int column = 0; column < scan.depth.width(); ++column) {
      // At so low a threshold noise alone makes points where no light falls.
      const bool is_lit = !std::isnan(scan.coordinate(column, row));
      if (!is_lit || cloud.validity(column, row) != Validity::valid) continue;
      const Eigen::Vector3d truth =
          ray_through(scanner.camera, {column, row}) * scan.depth(column, row);
      sum.x += square((cloud.x(column, row) - truth.x()) / sigma.x(column, row));
      sum.y += square((cloud.y(column, row) - truth.y()) / sigma.y(column, row));
      sum.z += square((cloud.z(column, row) - truth.z()) / sigma.z(column, row));
      sum.coordinate += square((maps.coordinate(column, row) - scan.coordinate(column, row)) /
                               sigma.coordinate(column, row));
      ++sum.points;
    }
  }
  const auto rms = [&](double squares) { return std::sqrt(squares / sum.points); };
  return {rms(sum.x), rms(sum.y), rms(sum.z), rms(sum.coordinate), sum.points};
}

TEST(Uncertainty, IsThatOfTheVirtualScannerWithinTenPercent) {
  for (const Strategy& strategy :
       {Strategy(DualFrequency{.steps = 3, .high = 16, .low = 1}),
        Strategy(PhaseChannelMultiplexing{.steps = 4, .high = 4, .share = {}, .reference = {}}),
        Strategy(PhaseChannelMultiplexing{.steps = 5, .high = {}, .share = {}, .reference = {}})}) {
    for (const double alpha : {0.15, 0.3, 0.5, 0.75, 1.0}) {
      for (const EngineKind kind : {EngineKind::reference, EngineKind::fused}) {
        const Normalised errors = normalised_errors(strategy, alpha, kind);
        SCOPED_TRACE(testing::Message() << strategy.name() << ", alpha " << alpha);
        EXPECT_GT(errors.points, 10000);
        EXPECT_NEAR(errors.x, 1, 0.1);
        EXPECT_NEAR(errors.y, 1, 0.1);
        EXPECT_NEAR(errors.z, 1, 0.1);
        EXPECT_NEAR(errors.coordinate, 1, 0.1);
      }
    }
  }
}

/// A scan of a virtual world, with its predicted errors.
struct PredictedScan {
  VirtualScan scan;
  Cloud cloud;
  Uncertainty sigma;
};

PredictedScan predicted_scan(const VirtualWorld& rig, const ReconstructSettings& settings = {},
                             const Strategy& strategy = DualFrequency{.steps = 3, .high = 16}) {
  const Sequence sequence{.strategy = strategy};

  PredictedScan result;
  result.scan = take_scan(rig.scanner, rig.scene, pattern_set(sequence), rig.photometry);
  Engine engine(as_calibrated(rig), sequence, settings);
  Maps maps;
  engine.cloud_and_maps(result.scan.frames, result.cloud, maps);
  result.sigma = engine.uncertainty(result.cloud, maps, result.scan.frames);
  return result;
}

PredictedScan predicted_scan(const char* world, const char* scene,
                             const ReconstructSettings& settings = {}) {
  VirtualWorld rig{.scanner = example_scanner({240, 180})};
  rig.scene = scene_named(scene, rig.scanner);
  rig.photometry = photometry_named(world);
  return predicted_scan(rig, settings);
}

/// Upright rods of a few camera pixels, a small step before a wall.
Scene rods_before_a_wall(const Scanner& scanner, double pixels, double step) {
  const WorkingVolume volume = working_volume(scanner);
  const double pixel = volume.centre.z() / scanner.camera.intrinsic(0, 0);
  const auto at = [&](double x, double z) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = volume.centre + Eigen::Vector3d(x, 0, z);
    return pose;
  };

  Scene scene;
  scene.push_back(Body{.shape = Board{volume.extent, volume.extent}, .pose = at(0, 0)});
  for (int i = -8; i <= 8; ++i) {
    const Eigen::Vector3d size(pixels * pixel, 0.6 * volume.extent, 0.1 * step);
    scene.push_back(Body{.shape = Box{size}, .pose = at(6.3 * i * pixel, -step)});
  }
  return scene;
}

// Smooth: where edges and contrast add at most a tenth to the noise.
TEST(Uncertainty, IsTheErrorOnSmoothPartsOfTenScenes) {
  const std::map<const char*, std::vector<const char*>> scenes{
      {"ideal", {"board", "sphere", "statue", "fish", "boxes"}},
      {"bench", {"board", "sphere", "statue", "fish", "contrast"}}};
  for (const auto& [world, names] : scenes) {
    for (const char* const scene : names) {
      const auto [scan, cloud, sigma] = predicted_scan(world, scene);
      double errors = 0, predicted = 0;
      for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
        if (cloud.validity(column, row) != Validity::valid) return;
        if (sigma.z(column, row) > 1.1F * sigma.z_of_noise(column, row)) return;
        errors += std::pow(cloud.z(column, row) - scan.depth(column, row), 2);
        predicted += std::pow(sigma.z(column, row), 2);
      });
      EXPECT_NEAR(std::sqrt(predicted / errors), 1, 0.05) << world << ", " << scene;
    }
  }
}

// Across a step of 2 % of the depth a mixture of both surfaces has all its modulation, so that it
// stays a point; the rods have hardly a pixel that the lens does not mix. The step is seventeen
// pixels wide: one below ten looks like a steep slope.
TEST(Uncertainty, CoversPixelsThatTheLensMixesAtSmallSteps) {
  VirtualWorld rig{.scanner = example_scanner({640, 480})};
  rig.photometry = photometry_named("bench");
  const Strategy strategy = MultiFrequency{.steps = {5}, .periods = {1, 3, 9, 27}};
  for (const double pixels : {1.5, 2.2, 3.0}) {
    rig.scene = rods_before_a_wall(rig.scanner, pixels, 12);
    const auto [scan, cloud, sigma] = predicted_scan(rig, {}, strategy);

    double points = 0, beyond = 0;
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      if (cloud.validity(column, row) != Validity::valid) return;
      const double error = std::abs(cloud.z(column, row) - scan.depth(column, row));
      if (!std::isfinite(error)) return;
      points += 1;
      if (error > 5 * sigma.z(column, row)) beyond += 1;
    });
    EXPECT_GT(points, 100000);
    EXPECT_LT(beyond, 0.015 * points) << pixels << " pixels";
  }
}

// A mask makes no edge.
TEST(Uncertainty, IsOfNoiseBesideMaskedPixels) {
  ReconstructSettings settings;
  settings.clean.outline = {{60, 40}, {180, 140}};
  const auto [scan, cloud, sigma] = predicted_scan("ideal", "board", settings);
  int beside = 0;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    for (const int x : {column - 1, column + 1}) {
      if (cloud.validity(x, row) != Validity::outside_region) continue;
      ++beside;
      EXPECT_LT(sigma.z(column, row), 1.2F * sigma.z_of_noise(column, row));
    }
  });
  EXPECT_GT(beside, 150);

  const PredictedRms rms = predicted_rms(sigma);
  EXPECT_LT(rms.with_edges, 1.05 * rms.of_noise);
  EXPECT_FALSE(rms.is_of_edges());
}

TEST(Uncertainty, IsMostlyOfEdgesForABodyInFrontOfNothing) {
  const PredictedRms rms = predicted_rms(predicted_scan("bench", "angel").sigma);
  EXPECT_TRUE(rms.is_of_edges());
}

/// Whose pixels have neighbours on one side alone.
TEST(Uncertainty, IsSaidOfAPictureOfOneRow) {
  const Scanner scanner = example_scanner({200, 1});
  const VirtualScan scan =
      scan_of_scene("board", scanner, pattern_set(PhaseMeasuring{}, Axis::x, light), photometry);
  Engine engine(scanner, {.strategy = PhaseMeasuring{}, .light = light});
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, scan.frames);
  for (int column = 0; column < 200; ++column) {
    EXPECT_EQ(std::isfinite(sigma.z(column, 0)), cloud.validity(column, 0) == Validity::valid);
  }
}

TEST(Uncertainty, IsNotSaidWhereThereIsNoPoint) {
  const Scanner scanner = example_scanner({80, 60});
  const Strategy strategy = DualFrequency{};
  const VirtualScan scan =
      scan_of_scene("sphere", scanner, pattern_set(strategy, Axis::x), photometry);
  Engine engine(scanner, {.strategy = strategy});
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, scan.frames);
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    ASSERT_EQ(std::isnan(sigma.z.begin()[i]), std::isnan(cloud.z.begin()[i]));
  }
}

}  // namespace slipstream::uncertainty_test
