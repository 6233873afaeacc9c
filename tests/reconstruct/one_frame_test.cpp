// Codings of one frame or two, against truth and against many steps of the same scene.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "decode/frame_adapter.h"
#include "decode/phase_decoder.h"
#include "frames/colour_channels.h"
#include "io/image_file.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/image.h"
#include "slipstream/named_scenes.h"
#include "slipstream/spatial_unwrapping.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/shared_data.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::one_frame_test {
namespace fs = std::filesystem;

using std::numbers::pi;

double quantile_of(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

TEST(OneFrame, HasThePhaseOfTwelveSteps) {
  const fs::path folder = shared_data() / "cpsd-plane";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<fs::path> files;
  for (int step = 1; step <= 12; ++step) {
    files.push_back(folder / ((step < 10 ? "f4_s0" : "f4_s") + std::to_string(step) + ".png"));
  }
  const LoadedFrames loaded = read_frames(files);
  const FrameViews frames = loaded.frames;
  const LoadedFrames masked = read_frames({folder / "mask_authors.png"});
  const Image<double> mask = weighted_sum(masked.frames, {1});
  const PhaseMaps steps = PhaseDecoder(PhaseMethod::equation, {12})(frames, 0, 12);
  const Strategy fourier = FourierProfilometry{.frequency = 64};
  const FrameSet read = demodulated(*fourier.demodulation(), Axis::x, frames.part(0, 1));
  const PhaseMaps one =
      PhaseDecoder(PhaseMethod::equation, {})(read, fourier.layout().bands.front());
  std::vector<double> errors;
  std::size_t valid = 0;
  Image<float> wrapped(mask.size(), NAN);
  for (std::size_t i = 0; i < mask.pixel_count(); ++i) {
    if (mask.begin()[i] == 0) continue;
    ++valid;
    if (one.modulation.begin()[i] < 15 * 257) continue;
    errors.push_back(one.wrapped_phase.begin()[i] + steps.wrapped_phase.begin()[i]);
    wrapped.begin()[i] = static_cast<float>(one.wrapped_phase.begin()[i]);
  }
  double constant_cosine = 0, constant_sine = 0;
  for (const double error : errors) {
    constant_cosine += std::cos(error);
    constant_sine += std::sin(error);
  }
  const double constant = std::atan2(constant_sine, constant_cosine);
  for (double& error : errors) {
    error = std::abs(std::remainder(error - constant, 2 * pi));
  }
  const auto share = static_cast<double>(errors.size()) / static_cast<double>(valid);
  std::cout << "share " << share << ", median " << quantile_of(errors, 0.5) << ", 90 % "
            << quantile_of(errors, 0.9) << " rad, constant " << constant << '\n';
  EXPECT_GT(share, 0.95);
  EXPECT_LE(quantile_of(errors, 0.5), 0.008);
  EXPECT_LE(quantile_of(errors, 0.9), 0.023);

  // Unwrapped in space it is the phase that the authors unwrapped in time, and one constant.
  const auto unwrapped = unwrap_in_space(wrapped, converted<float>(one.modulation));
  const Image<double> theirs = read_map(folder / "phase_authors.tiff");
  std::vector<double> differences;
  for (std::size_t i = 0; i < wrapped.pixel_count(); ++i) {
    if (std::isnan(wrapped.begin()[i])) continue;
    differences.push_back(unwrapped.phase.begin()[i] - theirs.begin()[i]);
  }
  const double usual = quantile_of(differences, 0.5);
  const auto same = std::count_if(differences.begin(), differences.end(), [&](double difference) {
    return std::abs(difference - usual) < pi;
  });
  const double same_share = static_cast<double>(same) / static_cast<double>(differences.size());
  std::cout << "unwrapped in space: " << same_share << " as in time\n";
  EXPECT_GE(same_share, 0.999);
}

/// Of grey surfaces mixed and taken apart; of painted ones mixed, taken apart, with a white
/// picture.
enum class Colour { none, mixed, apart, painted_mixed, painted, whitened };

struct OneFrameScan {
  Strategy strategy;
  std::string scene;
  double least_points;  ///< share of the lit pixels
  double most_median;   ///< mm
  double most_far;      ///< share of the points off by more than 1 mm
  bool painted = false;
  Colour colour = Colour::none;
  double most_wrong = 0;  ///< share of the points a period off
};

void PrintTo(const OneFrameScan& scan, std::ostream* out) {
  constexpr const char* in_colour[] = {"",
                                       ", in colours mixed",
                                       ", in colours taken apart",
                                       ", on colours mixed",
                                       ", on colours taken apart",
                                       ", on colours with a white picture"};
  *out << label_of(scan.strategy) << " of " << scan.scene << (scan.painted ? ", painted" : "")
       << in_colour[static_cast<std::size_t>(scan.colour)];
}

/// Whether the picture has such a depth near a pixel: windows carry a surface past its edge.
bool is_seen_near(const Image<double>& depth, int column, int row, double z) {
  constexpr int reach = 14;  // half of a window
  for (int y = std::max(row - reach, 0); y <= std::min(row + reach, depth.height() - 1); ++y) {
    for (int x = std::max(column - reach, 0); x <= std::min(column + reach, depth.width() - 1);
         ++x) {
      if (std::abs(depth(x, y) - z) < 30) return true;
    }
  }
  return false;
}

/// How far depths are off, mm, and how many pixels are lit.
struct DepthErrors {
  std::vector<double> errors;
  double lit = 0, far = 0, wrong = 0;  ///< pixels; off by more than 1 mm and by a period
};

/// In the world of a bench: blur, noise, a dim lamp.
VirtualScan scan_of(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                    Colour colour) {
  Photometry photometry{.ambient = 5, .noise_variance = 1.6, .bits = 8};
  photometry.physics.camera.blur = 0.6;
  if (colour == Colour::none) return take_scan(scanner, scene, patterns, photometry);
  const bool painted = colour >= Colour::painted_mixed;
  VirtualScan scan =
      take_colour_scan(scanner, scene, patterns, photometry, {usual_mixture, painted ? 0.3 : 0});
  const FrameViews white = colour == Colour::whitened ? FrameViews(scan.white) : FrameViews();
  if (colour != Colour::mixed && colour != Colour::painted_mixed)
    scan.frames = unmixed(scan.frames, usual_mixture, white);
  return scan;
}

DepthErrors depth_errors(const Strategy& strategy, const Scene& scene,
                         Colour colour = Colour::none) {
  const Scanner scanner = example_scanner({640, 480});
  const VirtualScan scan = scan_of(scanner, scene, pattern_set(strategy, Axis::x), colour);
  double nearest = INFINITY, farthest = 0;
  for (const double depth : scan.depth) {
    if (std::isnan(depth)) continue;
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  Engine engine(scanner, {.strategy = strategy},
                {.nearest = nearest - 5, .farthest = farthest + 5});
  Cloud cloud;
  engine.cloud(scan.frames, cloud);
  DepthErrors found;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (std::isnan(scan.coordinate.begin()[i])) continue;
    ++found.lit;
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    found.errors.push_back(std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]));
    found.far += found.errors.back() > 1 ? 1 : 0;
    const int column = static_cast<int>(i) % scan.depth.width(),
              row = static_cast<int>(i) / scan.depth.width();
    const bool right = is_seen_near(scan.depth, column, row, cloud.z.begin()[i]);
    found.wrong += right ? 0 : 1;
  }
  return found;
}

class OneFrameScans : public testing::TestWithParam<OneFrameScan> {};

TEST_P(OneFrameScans, AreNowhereAPeriodOff) {
  const auto& [strategy, name, least_points, most_median, most_far, painted, colour, most_wrong] =
      GetParam();
  Scene scene = scene_named(name, example_scanner({640, 480}));
  for (Body& body : scene) {
    if (painted) body.texture = veined_texture(0.3, 0.9, 20);
  }
  auto [errors, lit, far, wrong] = depth_errors(strategy, scene, colour);
  if (errors.empty()) {
    std::cout << "no points\n";
    EXPECT_EQ(least_points, 0);
    return;
  }
  const auto points = static_cast<double>(errors.size());
  std::cout << points / lit << " of the lit, median " << quantile_of(errors, 0.5) << " mm, 90 % "
            << quantile_of(errors, 0.9) << " mm, beyond 1 mm " << far / points << ", a period off "
            << wrong / points << '\n';
  EXPECT_GT(points / lit, least_points);
  EXPECT_LT(quantile_of(errors, 0.5), most_median);
  EXPECT_LT(far / points, most_far);
  EXPECT_LE(wrong / points, most_wrong);
}

INSTANTIATE_TEST_SUITE_P(
    Virtual, OneFrameScans,
    testing::Values(
        OneFrameScan{FourierProfilometry{.frequency = 32}, "sphere", 0.7, 0.2, 0.05},
        OneFrameScan{FourierProfilometry{.frequency = 48}, "board", 0.9, 0.05, 0.05},
        OneFrameScan{FourierProfilometry{.frequency = 32, .pi_shift = true}, "sphere", 0.7, 0.2,
                     0.05},
        OneFrameScan{FourierProfilometry{.frequency = 48, .pi_shift = true}, "board", 0.9, 0.05,
                     0.05},
        OneFrameScan{FourierProfilometry{.frequency = 48}, "board", 0, 0.2, 0.2, true},
        OneFrameScan{FourierProfilometry{.frequency = 48, .pi_shift = true}, "board", 0, 0.2, 0.2,
                     true},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "board", 0.9, 0.05, 0.1},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "board", 0.4, 0.5, 0.3, true},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "sphere", 0.6, 0.1, 0.05},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "sphere", 0.3, 0.3, 0.2,
                     true},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "statue", 0.6, 0.1, 0.1},
        OneFrameScan{FourierProfilometry{.frequency = 48, .low = 19}, "statue", 0.3, 0.8, 0.5,
                     true},
        OneFrameScan{FourierProfilometry{.frequency = 48, .pi_shift = true, .low = 19}, "statue",
                     0.6, 0.1, 0.1},
        // Which of its surfaces stands where, neither tells: that is doubtful, and no point wrong.
        OneFrameScan{FourierProfilometry{.frequency = 48}, "statue", 0, 0.2, 0.1},
        OneFrameScan{CompositePattern{}, "statue", 0, 0.2, 0.1},
        OneFrameScan{CompositePattern{}, "sphere", 0, 0.2, 0.1},
        OneFrameScan{CompositePattern{}, "board", 0.7, 0.05, 0.06}));

std::vector<OneFrameScan> of_two_carriers_and_paint() {
  const Strategy one = FourierProfilometry{.frequency = 48},
                 two = FourierProfilometry{.frequency = 48, .pi_shift = true},
                 numbered = FourierProfilometry{.frequency = 48, .pi_shift = true, .low = 19},
                 wide = FourierProfilometry{.frequency = 32},
                 wide_two = FourierProfilometry{.frequency = 32, .pi_shift = true},
                 composite = CompositePattern{};
  return {{numbered, "board", 0.9, 0.05, 0.1},
          {numbered, "board", 0.9, 0.3, 0.1, true},
          {composite, "board", 0, 0.2, 0.1, true},
          {wide, "sphere", 0.6, 0.4, 0.25, true},
          {wide_two, "sphere", 0.7, 0.2, 0.1, true},
          {numbered, "sphere", 0.6, 0.1, 0.05},
          {numbered, "sphere", 0.6, 0.3, 0.1, true},
          {composite, "sphere", 0, 0.2, 0.1, true},
          {two, "statue", 0, 0.2, 0.1},
          {one, "statue", 0, 0.2, 0.1, true},
          {two, "statue", 0, 0.2, 0.1, true},
          {numbered, "statue", 0.6, 0.5, 0.25, true},
          {composite, "statue", 0, 0.2, 0.1, true}};
}

INSTANTIATE_TEST_SUITE_P(Rest, OneFrameScans, testing::ValuesIn(of_two_carriers_and_paint()));

/// One period has no other to be off by; mixed or painted it is off by what it is.
std::vector<OneFrameScan> of_three_steps_in_colour() {
  const Strategy steps = PhaseMeasuring{.steps = 3, .frequency = 1};
  constexpr double any = 1.1;
  std::vector<OneFrameScan> scans;
  for (const char* const scene : {"board", "sphere", "statue"}) {
    for (const Colour colour : {Colour::mixed, Colour::painted_mixed, Colour::painted}) {
      scans.push_back({steps, scene, 0.2, 100, any, false, colour, any});
    }
    scans.push_back({steps, scene, 0.6, 8, any, false, Colour::apart, 0.05});
    scans.push_back({steps, scene, 0.6, 5, any, true, Colour::apart, 0.05});
    scans.push_back({steps, scene, 0.5, 15, any, false, Colour::whitened, 0.12});
  }
  return scans;
}

INSTANTIATE_TEST_SUITE_P(InColour, OneFrameScans, testing::ValuesIn(of_three_steps_in_colour()));

std::vector<OneFrameScan> by_neighbours() {
  std::vector<OneFrameScan> scans;
  for (const char* const scene : {"board", "sphere", "statue"}) {
    for (const bool painted : {false, true}) {
      scans.push_back({SymbolArray{}, scene, 0.5, 0.6, painted ? 0.35 : 0.1, painted});
      scans.push_back({DeBruijn{}, scene, painted ? 0.5 : 0.8, 0.2, 0.1, painted, Colour::apart});
    }
    for (const Colour colour : {Colour::mixed, Colour::painted, Colour::whitened}) {
      scans.push_back({DeBruijn{}, scene, 0.6, 1.5, 0.6, false, colour});
    }
    scans.push_back({DeBruijn{}, scene, 0.4, 1.5, 0.6, false, Colour::painted_mixed});
  }
  return scans;
}

INSTANTIATE_TEST_SUITE_P(ByNeighbours, OneFrameScans, testing::ValuesIn(by_neighbours()));

/// A statue that turns and comes nearer: each frame alone is a cloud.
TEST(OneFrame, OfAMovingStatueIsACloudEach) {
  const Scene still = scene_named("statue", example_scanner({640, 480}));
  for (const int frame : {0, 1, 2, 3}) {
    Scene scene = still;
    for (Body& body : scene) {
      if (body.fixed) continue;
      body.pose = Eigen::Translation3d(0.004 * frame * body.pose.translation()) * body.pose *
                  Eigen::AngleAxisd(0.05 * frame, Eigen::Vector3d::UnitY());
    }
    auto [errors, lit, far, wrong] =
        depth_errors(FourierProfilometry{.frequency = 48, .low = 19}, scene);
    const auto points = static_cast<double>(errors.size());
    ASSERT_GT(points, 0.25 * lit);
    std::cout << points / lit << " of the lit, median " << quantile_of(errors, 0.5) << " mm, "
              << wrong << " a period off\n";
    EXPECT_LT(quantile_of(errors, 0.5), 0.2);
    EXPECT_EQ(wrong, 0);
  }
}

/// Where the picture gives the order, in float as in double: the same points, and for the others
/// the same reason.
TEST(OneFrame, IsFusedAsItIsByTheEquations) {
  const Scanner scanner = example_scanner({320, 240});
  const ReconstructSettings range{.nearest = 490, .farthest = 770};
  const std::vector<std::pair<Strategy, ReconstructSettings>> cases = {
      {FourierProfilometry{.frequency = 48}, range},
      {CompositePattern{}, {}},
      {PhaseMeasuring{.frequency = 4}, {.nearest = 490, .farthest = 610}}};
  for (const auto& [strategy, settings] : cases) {
    const VirtualScan scan =
        scan_of_scene("board", scanner, pattern_set(strategy, Axis::x), {.noise_variance = 1});
    ReconstructSettings of_reference = settings;
    of_reference.engine = EngineKind::reference;
    Engine fused(scanner, {.strategy = strategy}, settings),
        reference(scanner, {.strategy = strategy}, of_reference);
    EXPECT_EQ(fused.backend_for(fused.merged(scan.frames)), "fused");
    Cloud in_float, in_double;
    Depth depth;
    fused.depth(scan.frames, depth);
    fused.cloud(scan.frames, in_float);
    reference.cloud(scan.frames, in_double);
    std::size_t points = 0, differing = 0;
    for (std::size_t i = 0; i < in_double.z.pixel_count(); ++i) {
      const Validity why = in_double.validity.begin()[i];
      differing += in_float.validity.begin()[i] != why ? 1U : 0U;
      if (why != Validity::valid || in_float.validity.begin()[i] != why) continue;
      ++points;
      ASSERT_NEAR(in_float.z.begin()[i], in_double.z.begin()[i], 1e-4 * in_double.z.begin()[i]);
      ASSERT_EQ(depth.z.begin()[i], in_float.z.begin()[i]);
    }
    std::cout << label_of(strategy) << ": " << points << " points, " << differing << " differ\n";
    EXPECT_GT(points, 10000U);
    EXPECT_LE(differing, 8U);
  }
}

TEST(OneFrame, OfBothAxesAndAnotherOriginIsTheSameSurface) {
  const Scanner scanner = example_scanner({320, 240});
  for (const Axis axis : {Axis::x, Axis::y}) {
    for (const double origin : {0.0, 2.5}) {
      const Strategy strategy =
          FourierProfilometry{.frequency = 40, .pi_shift = true, .shifts = {origin}};
      const VirtualScan scan =
          scan_of_scene("board", scanner, pattern_set(strategy, axis), {.bits = std::nullopt});
      Engine engine(scanner, {.strategy = strategy, .axis = axis},
                    {.nearest = 490, .farthest = 770});
      Maps maps;
      engine.maps(scan.frames, maps);
      std::vector<double> errors;
      for (int row = 30; row < 210; ++row) {
        for (int column = 30; column < 290; ++column) {
          if (std::isnan(scan.coordinate(column, row)) || maps.modulation(column, row) < 15 * 257) {
            continue;
          }
          const double phase = 2 * pi * 40 * scan.coordinate(column, row);
          errors.push_back(
              std::abs(std::remainder(maps.wrapped_phase(column, row) - phase, 2 * pi)));
        }
      }
      ASSERT_GT(errors.size(), 10000U);
      EXPECT_LT(quantile_of(errors, 0.5), 0.02) << name_of(axis) << " " << origin;
    }
  }
}

TEST(OneFrame, TakesOneExposureAndOneCycle) {
  Sequence sequence{.strategy = FourierProfilometry{}};
  EXPECT_NO_THROW(require_mergeable(sequence));
  sequence.exposures = {1, 4};
  EXPECT_THROW(require_mergeable(sequence), Error);
  sequence.exposures = {1};
  sequence.motion = 2;
  EXPECT_THROW(require_mergeable(sequence), Error);
}

}  // namespace slipstream::one_frame_test
