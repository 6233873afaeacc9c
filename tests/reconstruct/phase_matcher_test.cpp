#include "reconstruct/phase_matcher.h"

#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "bench/vector_target.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream::phase_matcher_test {

constexpr Size camera{320, 240};

/// A scene as both cameras look at it, traced once.
struct Pair {
  Pair(const char* scene_name, Size camera)
      : Pair(scene_name, example_scanner(camera), second_scanner(example_scanner(camera))) {}

  Pair(const char* scene_name, const Scanner& one, const Scanner& other)
      : first(one), second(other) {
    const Scene scene = scene_named(scene_name, first);
    const PatternSet patterns = pattern_set(DualFrequency{}, Axis::x);
    first_scan = take_scan(first, scene, patterns);
    second_scan = take_scan(second, seen_from_second(scene, first, second), patterns);
  }

  [[nodiscard]] Cloud matched(const Strategy& strategy, const Photometry& light,
                              const PhaseMatchSettings& match = {},
                              const ReconstructSettings& settings = {}) const {
    Photometry other_light = light;
    other_light.seed += 1000;
    const PatternSet patterns = pattern_set(strategy, Axis::x);
    return PhaseMatcher(first, second, {.strategy = strategy}, settings, match)(
               take_again(first_scan, patterns, light),
               take_again(second_scan, patterns, other_light))
        .cloud;
  }

  Scanner first, second;
  VirtualScan first_scan, second_scan;
};

struct DepthError {
  double rms = 0;  ///< mm
  double worst = 0;
  int points = 0;
};

DepthError error_of(const Cloud& cloud, const Image<double>& depth) {
  DepthError error;
  double sum = 0;
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double difference = cloud.z.begin()[i] - depth.begin()[i];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    error.worst = std::max(error.worst, std::abs(difference));
    ++error.points;
  }
  error.rms = std::sqrt(sum / error.points);
  return error;
}

TEST(PhaseMatcher, PhaseMatchingIsFreeOfGamma) {
  const Pair board("board", {640, 480});
  const Strategy strategy = DualFrequency{.steps = 3, .low_steps = 6, .high = 32, .low = 1};
  const Photometry linear{.ambient = 5, .noise_variance = 1.55, .bits = 8};
  Photometry bent = linear;
  bent.response = PowerLaw{2.2};
  const Image<double>& depth = board.first_scan.depth;
  const DepthError straight = error_of(board.matched(strategy, linear), depth);
  const DepthError distorted = error_of(board.matched(strategy, bent), depth);
  RecordProperty("rms_gamma_1", std::to_string(straight.rms));
  RecordProperty("rms_gamma_2_2", std::to_string(distorted.rms));
  EXPECT_GT(straight.points, 200000);
  EXPECT_GT(distorted.points, 0.97 * straight.points);
  EXPECT_LE(distorted.rms, 1.2 * straight.rms) << straight.rms;
  // One camera and the projector are off by as much as gamma bends the phase.
  const FrameSet frames = take_again(board.first_scan, pattern_set(strategy, Axis::x), bent);
  Cloud one;
  Engine(board.first, {.strategy = strategy}).cloud(frames, one);
  EXPECT_GT(error_of(one, depth).rms, 50 * distorted.rms);
}

TEST(PhaseMatcher, PhaseMatchingFindsTheFringeThatThreeStepsMistake) {
  // Three steps of the low frequency, bent, are off by more than half a fringe in places; in both
  // cameras alike.
  const Pair board("board", {160, 120});
  const Strategy strategy = DualFrequency{.steps = 3, .low_steps = 3, .high = 16, .low = 1};
  const Cloud cloud = board.matched(
      strategy, {.ambient = 5, .response = PowerLaw{2.2}, .noise_variance = 1.55, .bits = 8},
      {.window = 0});
  int near = 0, far = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const double error = std::abs(cloud.z.begin()[i] - board.first_scan.depth.begin()[i]);
    near += error < 5 ? 1 : 0;
    far += error > 20 ? 1 : 0;
  }
  EXPECT_GT(near, 15000);
  EXPECT_LT(far, near / 1000);
}

TEST(PhaseMatcher, ShowsNoWrongPointWhereTheSecondCameraDoesNotSee) {
  const Pair pair("boxes", camera);
  const Strategy strategy = DualFrequency{.steps = 4, .low_steps = 4, .high = 16, .low = 1};
  const Cloud cloud =
      pair.matched(strategy, {.ambient = 5, .noise_variance = 1.55, .bits = 8}, {.window = 0});
  const DepthError error = error_of(cloud, pair.first_scan.depth);
  EXPECT_GT(error.points, 3000);
  EXPECT_LT(error.worst, 5);
}

/// Of one high frequency alone; next to none of its points may be of another fringe.
void expect_order_by_second_camera(const char* scene, double periods, double least_share) {
  const Pair pair(scene, camera);
  const Cloud cloud =
      pair.matched(PhaseMeasuring{4, periods}, {.ambient = 5, .noise_variance = 1.55, .bits = 8},
                   {.window = 0}, {.nearest = 450, .farthest = 900});
  const double fringe = 600 / periods;  // mm, less than what a wrong order is off by
  int lit = 0, right = 0, wrong = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::too_dark) ++lit;
    const double error = std::abs(cloud.z.begin()[i] - pair.first_scan.depth.begin()[i]);
    right += error < fringe ? 1 : 0;
    wrong += error >= fringe ? 1 : 0;
  }
  EXPECT_GT(right, least_share * lit) << scene << ", " << periods << " periods, lit " << lit;
  EXPECT_LE(wrong, right / 500) << scene << ", " << periods << " periods";
}

TEST(PhaseMatcher, PhaseMatchingFindsTheOrderOfOneBandByTheSecondCamera) {
  expect_order_by_second_camera("board", 8, 0.95);
  expect_order_by_second_camera("board", 16, 0.95);
  expect_order_by_second_camera("sphere", 16, 0.65);
  expect_order_by_second_camera("boxes", 8, 0.8);
  expect_order_by_second_camera("boxes", 16, 0.75);
  expect_order_by_second_camera("statue", 8, 0.75);
  expect_order_by_second_camera("statue", 16, 0.65);
  expect_order_by_second_camera("statue", 32, 0.6);
}

struct SceneAndStrategy {
  const char* scene;
  const char* strategy;
  double least_share;  ///< of the lit pixels that become points
};

class PhaseMatcherEveryPair : public testing::TestWithParam<SceneAndStrategy> {};

TEST_P(PhaseMatcherEveryPair, IsTheTruth) {
  const auto& [scene, name, least_share] = GetParam();
  const Pair pair(scene, camera);
  const Strategy strategy = make_strategy(name, {});
  const Cloud cloud =
      pair.matched(strategy, {.ambient = 5, .noise_variance = 1.55, .bits = 8}, {.window = 0});
  const DepthError error = error_of(cloud, pair.first_scan.depth);
  const auto dark = count_by_validity(cloud)[static_cast<std::size_t>(Validity::too_dark)];
  const double lit = static_cast<double>(cloud.z.pixel_count() - dark);
  EXPECT_GT(error.points, least_share * lit) << scene << ", " << name;
  EXPECT_LT(error.rms, 2) << scene << ", " << name;
  // A point of another fringe is off by more.
  const double half_fringe = std::max(10.0, 300 / highest_frequency(strategy));  // mm
  int far = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    far += std::abs(cloud.z.begin()[i] - pair.first_scan.depth.begin()[i]) > half_fringe ? 1 : 0;
  }
  EXPECT_LE(far, error.points / 1000) << scene << ", " << name;
}

INSTANTIATE_TEST_SUITE_P(Scenes, PhaseMatcherEveryPair,
                         testing::Values(SceneAndStrategy{"board", "dual-frequency", 0.9},
                                         SceneAndStrategy{"statue", "multi-frequency", 0.7},
                                         SceneAndStrategy{"statue", "pcmp", 0.6},
                                         SceneAndStrategy{"sphere", "gray-phase", 0.6}),
                         [](const auto& info) {
                           std::string name = std::string(info.param.scene) + info.param.strategy;
                           std::erase(name, '-');
                           return name;
                         });

TEST(PhaseMatcher, MatchesThroughABentLensOnEveryVectorTarget) {
  const Scanner first = example_scanner({160, 120});
  Scanner second = second_scanner(first);
  second.camera.distortion = make_distortion(std::array{-0.07, -0.18, 2e-3, 6e-3, 0.4, 0.1, -0.2,
                                                        0.3, 1e-2, -2e-2, 5e-3, 1e-2, 0.02, -0.03});
  second.camera.residual = {.centre = {80, 60}, .half = {80, 60}};
  second.camera.residual.terms = {{0.8, -0.9}, {0.7, 0.6}, {-0.5, 0.9}};
  const Pair board("board", first, second);
  const Photometry light{.ambient = 5, .noise_variance = 1.55, .bits = 8};

  second.camera.residual = {};
  const Pair plain("board", first, second);
  const double plain_rms =
      error_of(plain.matched(DualFrequency{}, light), plain.first_scan.depth).rms;
  std::size_t most = 0;

  for (const std::string& target : vector_targets()) {
    const OnlyVectorTarget only(target);
    const Cloud cloud = board.matched(DualFrequency{}, light);
    const DepthError error = error_of(cloud, board.first_scan.depth);
    EXPECT_GT(error.points, 15000) << target;
    EXPECT_LT(error.rms, 1.1 * plain_rms) << target;

    if (most == 0) most = point_count(cloud);
    EXPECT_NEAR(static_cast<double>(point_count(cloud)), static_cast<double>(most), 2) << target;
  }
}

TEST(PhaseMatcher, TakesPicturesNarrowerThanAVectorAndWithoutBits) {
  for (const auto& [size, bits] :
       {std::pair(Size{12, 30}, std::optional(8)), std::pair(Size{80, 60}, std::optional<int>())}) {
    const Pair pair("board", size);
    for (const int steps : {3, 4, 5}) {
      const Cloud cloud = pair.matched(PhaseChannelMultiplexing{.steps = steps},
                                       {.ambient = 5, .noise_variance = 1.55, .bits = bits});
      EXPECT_EQ(cloud.size(), size);
      if (size.width > 12) {
        EXPECT_GT(point_count(cloud), 500U) << steps;
      }
    }
  }
}

TEST(PhaseMatcher, LeavesOutPlacesThatTheOtherAxisContradicts) {
  const Scanner first = example_scanner(camera), second = second_scanner(first);
  const Scene scene = scene_named("boxes", first);
  const Photometry light{.ambient = 5, .noise_variance = 1.55, .bits = 8};
  Photometry other_light = light;
  other_light.seed = 1001;
  const Sequence both{.strategy = DualFrequency{}, .both_axes = true};
  const auto scan_of = [&](const Scanner& scanner, const Scene& seen, const Photometry& by) {
    return merged({.frames = take_scan(scanner, seen, pattern_set(both), by).frames,
                   .sequence = both,
                   .scanner = scanner});
  };
  const Scan one = scan_of(first, scene, light);
  const Scan other = scan_of(second, seen_from_second(scene, first, second), other_light);
  PhaseMatcher match(first, second, one.sequence, {}, {.window = 0});
  const Cloud along_x = match(one.frames, other.frames).cloud;
  const Cloud along_both = match(one, other).cloud;
  EXPECT_GT(point_count(along_both), 0.9 * point_count(along_x));
  EXPECT_LE(point_count(along_both), point_count(along_x));

  // Frames along y of another scene contradict nearly every match along x.
  Scan wrong = other;
  wrong.other_axis.front().frames = one.other_axis.front().frames;
  EXPECT_LT(point_count(match(one, wrong).cloud), 0.7 * point_count(along_x));
}

TEST(PhaseMatcher, FindsDepthsAndOriginByItself) {
  const Pair statue("statue", camera);
  const Photometry light{.ambient = 5, .noise_variance = 1.55, .bits = 8};
  Photometry other_light = light;
  other_light.seed += 1000;
  const PatternSet patterns = pattern_set(PhaseMeasuring{4, 8, {.origin = -1.2}}, Axis::x);
  const FrameSet first = take_again(statue.first_scan, patterns, light);
  const FrameSet second = take_again(statue.second_scan, patterns, other_light);
  const auto matched = [&](double origin) {
    return PhaseMatcher(statue.first, statue.second,
                        {.strategy = PhaseMeasuring{4, 8, {.origin = origin}}}, {},
                        {.window = 0})(first, second);
  };
  const PhaseMatcher::Result known = matched(-1.2), wrong = matched(0);
  ASSERT_TRUE(known.agreement);
  EXPECT_EQ(known.agreement->phase_shift, 0);
  EXPECT_GT(known.agreement->depths.nearest, 300);
  EXPECT_LT(known.agreement->depths.farthest, 1500);
  ASSERT_TRUE(wrong.agreement);
  EXPECT_NEAR(wrong.agreement->phase_shift, 1.2, 0.1);
  EXPECT_GT(point_count(wrong.cloud), 0.95 * point_count(known.cloud));
  for (const PhaseMatcher::Result* result : {&known, &wrong}) {
    EXPECT_LT(error_of(result->cloud, statue.first_scan.depth).rms, 3);
  }
}

TEST(PhaseMatcher, RefusesWhatIsNoPair) {
  const Scanner first = example_scanner(camera), second = second_scanner(first);
  const auto sequence = [](const Strategy& strategy) { return Sequence{.strategy = strategy}; };
  const Sequence dual = sequence(DualFrequency{});
  EXPECT_THROW(PhaseMatcher(first, second, dual, {.minimum_modulation = -1}), Error);
  EXPECT_THROW(PhaseMatcher(first, first, dual), Error);
  EXPECT_THROW(PhaseMatcher(first, second, sequence(make_strategy("gray-code", {}))), Error);
  EXPECT_THROW(PhaseMatcher(first, second, dual, {}, {.window = -1}), Error);
  Scanner other = second;
  other.projector.size = {640, 480};
  EXPECT_THROW(PhaseMatcher(first, other, dual), Error);
  const FrameSet small(FrameSet::Images8(6, Image<std::uint8_t>({80, 60})));
  EXPECT_THROW(static_cast<void>(PhaseMatcher(first, second, dual)(small, small)), Error);
}

}  // namespace slipstream::phase_matcher_test
