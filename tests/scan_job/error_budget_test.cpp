// What a scan's error budget adds up to, against the depth error of virtual scans.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/scan_job.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::error_budget_test {

/// A scan of a virtual world, with its truth.
struct KnownScan {
  Scan scan;
  Image<double> depth;
};

KnownScan scan_of(const VirtualWorld& world, const Strategy& strategy, bool both_axes = false) {
  const Sequence sequence{
      .strategy = strategy, .projector = world.scanner.projector.size, .both_axes = both_axes};
  VirtualScan taken =
      take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
  return {merged({.frames = std::move(taken.frames),
                  .sequence = sequence,
                  .scanner = as_calibrated(world)}),
          std::move(taken.depth)};
}

ScanResult result_of(const KnownScan& known) {
  return reconstruct(known.scan, {.uncertainty = true});
}

std::optional<double> error_of(const ScanResult& result, const std::string& source) {
  const auto found = std::ranges::find(result.budget->sources, source, &ErrorSource::name);
  EXPECT_NE(found, result.budget->sources.end()) << source;
  return found->depth;
}

/// A scene of the bench at a random place, of random brightness, patterns and camera, and with an
/// uncorrected gamma that hardly bends the phase.
KnownScan random_scan(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto one_of = [&](const auto& choices) {
    return choices[std::uniform_int_distribution<std::size_t>(0, choices.size() - 1)(random)];
  };

  const std::array scenes{"board", "sphere", "boxes", "statue", "contrast", "angel", "fish"};
  const std::array strategies{
      "dual-frequency, steps 3, high 16",         "dual-frequency, steps 4, high 16",
      "dual-frequency, steps 4, high 32",         "dual-frequency, steps 8, high 64",
      "multi-frequency, steps 4, periods 1,8,64", "pcmp, steps 5"};

  WorldSettings settings{.scene = one_of(scenes), .camera = {320, 240}, .seed = seed};
  settings.shift = {between(-20, 20), between(-20, 20), between(-40, 40)};
  settings.bits = one_of(std::array{8, 8, 10, 12});
  settings.ambient = between(0, 15);
  if (between(0, 1) < 0.5) settings.reflectivity = between(0.3, 0.9);
  const Strategy strategy = strategy_labelled(one_of(strategies));
  if (between(0, 1) < 0.5) settings.response = PowerLaw{between(1, 1.03)};
  return scan_of(virtual_world(settings), strategy);
}

/// RMS error of depth, mm; at edges against the nearest depth around the pixel.
double true_error(const Cloud& cloud, const Image<double>& depth) {
  double squares = 0, count = 0;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    constexpr double far = 0.01;  // of the depth
    const double z = cloud.z(column, row), at_centre = z - depth(column, row);
    const double error =
        std::abs(at_centre) > far * z ? nearest_error(z, depth, column, row) : at_centre;
    if (!std::isfinite(error)) return;
    squares += error * error;
    ++count;
  });
  return std::sqrt(squares / count);
}

/// Total of the budget over the true RMS error.
double ratio_of(unsigned seed) {
  const KnownScan known = random_scan(seed);
  const ScanResult result = result_of(known);
  const double rms = true_error(result.cloud, known.depth);
  const double ratio = result.budget->total() / rms;
  std::printf("%3u %-45s %5.3f", seed, label_of(known.scan.sequence.strategy).c_str(), ratio);
  std::printf("  true %.4f mm:", rms);
  for (const auto& [name, depth, found] : result.budget->sources) {
    if (depth) std::printf(" %s %.4f", name.c_str(), *depth);
  }
  std::printf("\n");
  return ratio;
}

int number_within(unsigned first, unsigned last) {
  int within = 0;
  for (unsigned seed = first; seed <= last; ++seed) {
    const double ratio = ratio_of(seed);
    within += ratio >= 0.8 && ratio <= 1.25 ? 1 : 0;
  }
  return within;
}

VirtualWorld board(const char* world) {
  return virtual_world({.scene = "board", .camera = {160, 120}, .world = world});
}

TEST(ErrorBudget, HasTheGammaThatFourStepsShow) {
  VirtualWorld world = board("ideal");
  world.photometry.response = PowerLaw{1.2};
  world.photometry.noise_variance = 0.02;  // far less than gamma
  world.photometry.bits.reset();

  const KnownScan known = scan_of(world, DualFrequency{.steps = 4, .high = 16});
  const ScanResult result = result_of(known);
  const double error = true_error(result.cloud, known.depth);
  EXPECT_NEAR(error_of(result, "gamma").value(), error, 0.2 * error);
  EXPECT_LT(error_of(result, "noise").value(), 0.5 * error);

  const ScanResult three = result_of(scan_of(world, DualFrequency{.steps = 3, .high = 16}));
  EXPECT_FALSE(error_of(three, "gamma"));
}

TEST(ErrorBudget, KnowsTheCalibrationByBothAxesOrTheReprojectionError) {
  const VirtualWorld world = board("ideal");
  KnownScan known = scan_of(world, DualFrequency{});
  const ScanResult unknown = result_of(known);
  EXPECT_FALSE(error_of(unknown, "calibration"));

  // A reprojection error of half a pixel.
  known.scan.scanner->calibration_rms = 0.5;
  const ScanResult reprojected = result_of(known);
  EXPECT_GT(error_of(reprojected, "calibration").value(), 0.1);
  EXPECT_EQ(reprojected.uncertainty->z_systematic.size(), reprojected.cloud.size());

  // Both axes show that the projector's principal point is off by as much.
  known = scan_of(world, DualFrequency{}, true);
  known.scan.scanner->projector.intrinsic(1, 2) += 0.5;
  const ScanResult both = result_of(known);
  EXPECT_NEAR(error_of(both, "calibration").value(), error_of(reprojected, "calibration").value(),
              0.3 * error_of(reprojected, "calibration").value());
  EXPECT_LT(error_of(both, "lens model").value(), error_of(both, "calibration").value());
}

TEST(ErrorBudget, AddsUpToTheErrorOfRandomScenes) {
  EXPECT_GE(number_within(1, 8), 7);
}

TEST(ErrorBudget, AddsUpToTheErrorOfAHundredRandomScenes) {
  EXPECT_GE(number_within(1, 100), 90);
}

}  // namespace slipstream::error_budget_test
