// Two calibrated cameras and a projector of unknown calibration.
#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "reconstruct/coordinate_matcher.h"
#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_world.h"

namespace slipstream::without_projector_test {

const Strategy gray = GrayCode{.bits = 9, .stripes = 400.0};
const Strategy gray_phase = GrayPhase{};
const Strategy phases = DualFrequency{.steps = 4, .low_steps = 4, .high = 32, .low = 1};

/// A scene seen by two cameras with different, distorting lenses.
struct Rig {
  /// `lift`: of the second camera over the line through the first and the projector, mm.
  explicit Rig(const char* scene_name, double lift = 0) : first(example_scanner({320, 240})) {
    first.camera.distortion = make_distortion(std::array{-0.25, 0.1, 0.002, -0.001});
    second = second_scanner(first);
    second.camera.distortion = make_distortion(std::array{-0.2, 0.05, -0.001, 0.002});
    second.camera.intrinsic.topLeftCorner<2, 2>() *= 0.9;
    second.translation += second.rotation * Eigen::Vector3d(0, lift, 0);
    const Scene scene = scene_named(scene_name, first);
    seen_first = take_scan(first, scene, pattern_set(phases, Axis::x));
    seen_second =
        take_scan(second, seen_from_second(scene, first, second), pattern_set(phases, Axis::x));
    pair.camera = first.camera;
    pair.projector = second.camera;
    pair.rotation = second.rotation.transpose() * first.rotation;
    pair.translation = second.rotation.transpose() * (first.translation - second.translation);
    pair.photometry.noise_variance = noise + 1.0 / 12;
  }

  [[nodiscard]] Scan taken(const VirtualScan& seen, const Strategy& strategy, Axis axis,
                           std::uint64_t seed) const {
    const Photometry light{.ambient = 5, .noise_variance = noise, .bits = 8, .seed = seed};
    Scan scan{.frames = take_again(seen, pattern_set(strategy, axis), light),
              .sequence = {.strategy = strategy, .axis = axis}};
    scan.sequence.projector = first.projector.size;
    return scan;
  }

  [[nodiscard]] Scan scan(const Strategy& strategy, bool both_axes = false) const {
    Scan scan = taken(seen_first, strategy, Axis::x, 1);
    scan.further_cameras.push_back(taken(seen_second, strategy, Axis::x, 2));
    if (!both_axes) return scan;
    scan.other_axis.push_back(taken(seen_first, strategy, Axis::y, 3));
    scan.further_cameras[0].other_axis.push_back(taken(seen_second, strategy, Axis::y, 4));
    return scan;
  }

  /// Depth is as much more exact as the baseline is longer.
  [[nodiscard]] double longer_baseline() const {
    return pair.translation.norm() / first.translation.norm();
  }

  static constexpr double noise = 1.55;
  Scanner first, second, pair;
  VirtualScan seen_first, seen_second;
};

struct DepthErrors {
  std::size_t points = 0;
  double rms = 0;    ///< mm, of errors up to 1 % of the depth
  double wrong = 0;  ///< share of larger errors
  double ratio = 0;  ///< robust standard deviation of the errors over their uncertainty
};

DepthErrors errors_of(const Cloud& cloud, const Image<double>& truth,
                      const Image<float>* sigma = nullptr) {
  DepthErrors errors;
  double sum = 0, near = 0;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double Z = cloud.z.begin()[i], error = Z - truth.begin()[i];
    if (!std::isfinite(error)) continue;
    ++errors.points;
    if (sigma != nullptr) ratios.push_back(std::abs(error) / sigma->begin()[i]);
    if (std::abs(error) > 0.01 * Z) continue;
    sum += error * error;
    ++near;
  }
  errors.rms = std::sqrt(sum / near);
  errors.wrong = 1 - near / static_cast<double>(errors.points);
  if (!ratios.empty()) errors.ratio = deviation_from_median(median(ratios));
  return errors;
}

DepthErrors matched(const Rig& rig, const Scan& scan, const ReconstructSettings& settings = {}) {
  const auto [cloud, maps, uncertainty] =
      CoordinateMatcher(rig.pair, scan.sequence, settings)(scan);
  return errors_of(cloud, rig.seen_first.depth, &uncertainty.z);
}

class WithoutProjectorNoise : public testing::TestWithParam<Strategy> {};

TEST_P(WithoutProjectorNoise, IsThatOfTheProjectorAtTheSameBaseline) {
  for (const char* const scene : {"board", "sphere"}) {
    const Rig rig(scene);
    const Scan scan = rig.scan(GetParam());
    Cloud by_projector;
    Engine(rig.first, scan.sequence).cloud(scan.frames, by_projector);
    const DepthErrors one = errors_of(by_projector, rig.seen_first.depth);
    const DepthErrors two = matched(rig, scan);
    SCOPED_TRACE(fmt::format("{}: projector {} points, {} mm; pair {} points, {} mm", scene,
                             one.points, one.rms, two.points, two.rms));
    EXPECT_LE(two.rms * rig.longer_baseline(), 1.5 * one.rms);
    EXPECT_LE(two.wrong, 0.001);
    EXPECT_GE(two.points, 0.9 * static_cast<double>(one.points));
    EXPECT_NEAR(two.ratio, 1, 0.35);
  }
}

INSTANTIATE_TEST_SUITE_P(Strategies, WithoutProjectorNoise,
                         testing::Values(gray, gray_phase, phases), [](const auto& tested) {
                           return tested.index == 0   ? "gray"
                                  : tested.index == 1 ? "gray_phase"
                                                      : "phases";
                         });

/// Lifts the second camera to the height of the first: epipolar lines run along rows, and the
/// projector is above them.
constexpr double level = 176;

TEST(WithoutProjector, BothAxesExcludeWrongPlaces) {
  // A surface hidden from one camera may have the coordinate of another on its epipolar line.
  const Rig rig("statue", level);
  const ReconstructSettings raw{.clean = CleanSettings::none()};
  for (const Strategy& strategy : {gray, phases}) {
    const DepthErrors one = matched(rig, rig.scan(strategy));
    const DepthErrors one_raw = matched(rig, rig.scan(strategy), raw);
    const DepthErrors both_raw = matched(rig, rig.scan(strategy, true), raw);
    SCOPED_TRACE(fmt::format("wrong: {} with one axis, {} before cleaning; {} with both", one.wrong,
                             one_raw.wrong, both_raw.wrong));
    EXPECT_LE(one.wrong, 0.002);
    EXPECT_LE(one_raw.wrong, 0.02);
    EXPECT_LE(both_raw.wrong, 0.001);
    EXPECT_GE(both_raw.points, 0.97 * static_cast<double>(one_raw.points));
  }
}

TEST(WithoutProjector, MatchesTheAxisThatChangesAlongTheEpipolarLines) {
  const Rig rig("board", level);
  Scan scan = rig.scan(phases, true);
  const DepthErrors x_first = matched(rig, scan);
  for (Scan* const camera : {&scan, &scan.further_cameras[0]}) {
    std::swap(camera->frames, camera->other_axis[0].frames);
    std::swap(camera->sequence, camera->other_axis[0].sequence);
  }
  EXPECT_EQ(matched(rig, scan).rms, x_first.rms);
  const Maps maps = CoordinateMatcher(rig.pair, scan.sequence)(scan).maps;
  scan.other_axis.clear();
  const Maps alone = CoordinateMatcher(rig.pair, scan.sequence)(scan).maps;
  EXPECT_TRUE(std::ranges::equal(maps.wrapped_phase, alone.wrapped_phase))
      << "along the scan's own axis, whichever was matched";
  const DepthErrors y_alone = matched(rig, scan);
  EXPECT_GT(y_alone.rms, 2 * x_first.rms);
  EXPECT_NEAR(y_alone.ratio, 1, 0.2) << "known to be less exact";
}

TEST(WithoutProjector, RefusesWhatGivesNoCoordinate) {
  const Rig rig("board");
  const Strategy wrapped = PhaseMeasuring{.steps = 4, .frequency = 8};
  EXPECT_THROW(CoordinateMatcher(rig.pair, {.strategy = wrapped}), Error);
  Scan alone = rig.scan(phases);
  alone.further_cameras.clear();
  EXPECT_THROW(static_cast<void>(CoordinateMatcher(rig.pair, alone.sequence)(alone)), Error);
}

/// A frame of each pattern of the strategy, all of whose pixels see the same stripe.
FrameSet frames_of_one_stripe(const Strategy& strategy, Size size, double y) {
  const PatternSet patterns = pattern_set(strategy, Axis::x);
  FrameSet::Images8 frames;
  for (int n = 0; n < patterns.count; ++n) {
    const double level = 20 + 0.8 * patterns.intensity(n, y);
    frames.emplace_back(size, static_cast<std::uint8_t>(level));
  }
  return frames;
}

TEST(WithoutProjector, ASingleStripeGivesNoPoint) {
  const Rig rig("board");
  Scan scan = rig.scan(gray);
  const Size size = rig.pair.projector.size;
  scan.further_cameras[0].frames = frames_of_one_stripe(gray, size, 0.5012);
  const auto result = CoordinateMatcher(rig.pair, {.strategy = gray})(scan);
  EXPECT_LT(point_count(result.cloud), scan.frames.size().width * 240U / 20);
}

}  // namespace slipstream::without_projector_test
