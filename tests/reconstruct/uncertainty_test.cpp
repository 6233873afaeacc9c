// What a scan says of its own depth noise, against the depth noise of virtual scans.
#include <cmath>

#include <gtest/gtest.h>

#include "codes/predicted_variance.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
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
