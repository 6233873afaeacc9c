// The fused pass against the equations in double, on every vector target of the machine.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "bench/vector_target.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_engine.h"
#include "response/correction.h"
#include "slipstream/frame_set.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"

namespace slipstream::fused_phase_test {

constexpr double phase_bound = 2e-6;  // rad

double apart_on_circle(double a, double b) {
  const double difference = std::abs(a - b);
  return std::min(difference, 2 * std::numbers::pi - difference);
}

/// Frames of a camera of so many bits: rows of random pixels, of few grey levels, black, white,
/// saturated in one frame, and constant in all frames but one.
template <class Pixel>
std::vector<Image<Pixel>> hard_frames(int count, Size size, int bits, unsigned seed) {
  std::mt19937 random(seed);
  const int full = (1 << bits) - 1;
  const auto up_to = [&](int largest) {
    return static_cast<Pixel>(std::uniform_int_distribution<int>(0, largest)(random));
  };
  std::vector<Image<Pixel>> frames(static_cast<std::size_t>(count), Image<Pixel>(size));
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const Pixel shared = up_to(full);
      for (std::size_t n = 0; n < frames.size(); ++n) {
        Pixel& pixel = frames[n](column, row);
        switch (row % 6) {
          case 0:
            pixel = up_to(full);
            break;
          case 1:
            pixel = static_cast<Pixel>(full - up_to(1));
            break;
          case 2:
            pixel = 0;
            break;
          case 3:
            pixel = static_cast<Pixel>(full);
            break;
          case 4:
            pixel = n == 0 ? static_cast<Pixel>(full) : up_to(full / 2);
            break;
          default:
            pixel = n == 1 ? up_to(full) : shared;
            break;
        }
      }
    }
  }
  return frames;
}

FrameSet frame_set(std::vector<Image<std::uint8_t>> frames, int) {
  return FrameSet(std::move(frames));
}
FrameSet frame_set(std::vector<Image<std::uint16_t>> frames, int bits) {
  return FrameSet(std::move(frames), bits);
}

template <class Pixel>
PhaseSample by_equations(const std::vector<Image<Pixel>>& frames, int first, int steps, int column,
                         int row) {
  std::vector<double> intensities;
  for (int n = first; n < first + steps; ++n) {
    intensities.push_back(frames[static_cast<std::size_t>(n)](column, row));
  }
  return PhaseEquations(steps)(intensities);
}

/// The fused pass of an example scanner whose camera has that size.
std::optional<FusedEngine> fused(Size size, const Strategy& strategy, Axis axis = Axis::x,
                                 const PhaseCorrections& corrections = {}) {
  return FusedEngine::make({example_scanner(size), {.strategy = strategy, .axis = axis}, {}},
                           corrections);
}

Maps maps_of(const FusedEngine& reconstruct, const FrameViews& frames) {
  Maps maps;
  FusedMemory memory;
  reconstruct(frames, {.maps = &maps}, memory);
  return maps;
}

template <class Pixel>
void expect_phase_of_equations(int steps, int width, int bits, bool dual) {
  const Size size{width, 24};
  const Strategy strategy = dual ? Strategy(DualFrequency{.steps = steps, .high = 16, .low = 1})
                                 : Strategy(PhaseMeasuring{.steps = steps, .frequency = 1});
  const auto frames = hard_frames<Pixel>(frame_count(strategy), size, bits,
                                         static_cast<unsigned>(1000 * steps + width + bits));
  const auto reconstruct = fused(size, strategy);
  ASSERT_TRUE(reconstruct);
  const Maps decoding = maps_of(*reconstruct, frame_set(frames, bits));
  const double full = (1 << bits) - 1;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      PhaseSample expected = by_equations(frames, 0, steps, column, row);
      const PhaseSample low = dual ? by_equations(frames, steps, steps, column, row) : expected;
      EXPECT_NEAR(decoding.mean(column, row), expected.mean, 1e-6 * full);
      EXPECT_NEAR(decoding.modulation(column, row), std::min(expected.modulation, low.modulation),
                  1e-6 * full);
      const float phase = decoding.wrapped_phase(column, row);
      ASSERT_TRUE(phase >= 0 && phase < 2 * std::numbers::pi) << phase;
      // Without any modulation the sums are rounding and no angle.
      if (expected.modulation < 1e-9) continue;
      ASSERT_LE(apart_on_circle(phase, expected.wrapped_phase), phase_bound)
          << "row " << row << ", column " << column;
    }
  }
}

class FusedPhase : public testing::TestWithParam<std::string> {};

TEST_P(FusedPhase, IsThatOfTheEquationsForEveryInput) {
  const OnlyVectorTarget only(GetParam());
  for (const int steps : {3, 4, 5, 6, 9}) {
    for (const int width : {32, 33, 47}) {
      SCOPED_TRACE(testing::Message() << steps << " steps, width " << width);
      expect_phase_of_equations<std::uint8_t>(steps, width, 8, false);
      expect_phase_of_equations<std::uint16_t>(steps, width, 10, true);
      expect_phase_of_equations<std::uint16_t>(steps, width, 16, false);
    }
  }
}

/// All phases of 3, 4 and 6 frames whose intensities are multiples of an odd number, so that every
/// octant and both ends of each are met.
TEST_P(FusedPhase, IsThatOfTheEquationsAllAroundTheCircle) {
  const OnlyVectorTarget only(GetParam());
  constexpr int level = 51;  // 0, 51, ..., 255
  const Size size{216, 40};
  for (const int steps : {3, 4, 6}) {
    std::vector<Image<std::uint8_t>> frames(static_cast<std::size_t>(steps),
                                            Image<std::uint8_t>(size));
    int number = 0;
    for (std::size_t pixel = 0; pixel < frames[0].pixel_count(); ++pixel, number += 7) {
      int digits = number;
      for (Image<std::uint8_t>& frame : frames) {
        frame.begin()[pixel] = static_cast<std::uint8_t>(level * (digits % 6));
        digits /= 6;
      }
    }
    const auto reconstruct = fused(size, PhaseMeasuring{.steps = steps, .frequency = 1}, Axis::y);
    const Maps decoding = maps_of(*reconstruct, FrameSet(frames));
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const PhaseSample expected = by_equations(frames, 0, steps, column, row);
        ASSERT_LE(apart_on_circle(decoding.wrapped_phase(column, row), expected.wrapped_phase),
                  phase_bound);
      }
    }
  }
}

/// What gamma asks for: an odd function, whose harmonics fall off as powers of `ratio`.
PhaseCorrection gamma_correction(int steps, double ratio) {
  PhaseCorrection correction{steps, {}};
  constexpr int entries = 4096;
  for (int i = 0; i < entries; ++i) {
    const double angle = 2 * std::numbers::pi * i / entries;
    correction.added.push_back(std::atan2(ratio * std::sin(angle), 1 + ratio * std::cos(angle)));
  }
  return correction;
}

/// A correction that is no odd function.
PhaseCorrection wavy_correction(int steps) {
  PhaseCorrection correction{steps, {}};
  constexpr int entries = 256;
  for (int i = 0; i < entries; ++i) {
    const double angle = 2 * std::numbers::pi * i / entries;
    correction.added.push_back(0.3 * (std::sin(angle) + 0.2 * std::cos(2 * angle)));
  }
  return correction;
}

/// Most that the correction adds from one phase to another, as a share of the way between them: an
/// error of the measured phase grows by it.
double steepest(const PhaseCorrection& correction) {
  double most = 0;
  for (std::size_t i = 0; i < correction.added.size(); ++i) {
    const double next = correction.added[(i + 1) % correction.added.size()];
    most = std::max(most, std::abs(next - correction.added[i]));
  }
  const auto entries = static_cast<double>(correction.added.size());
  return most * entries * correction.steps / (2 * std::numbers::pi);
}

TEST_P(FusedPhase, IsCorrected) {
  const OnlyVectorTarget only(GetParam());
  const Size size{33, 24};
  for (const PhaseCorrection& correction :
       {gamma_correction(3, 0.28), gamma_correction(4, 0.1), gamma_correction(5, 0.6),
        wavy_correction(3), wavy_correction(6), phase_correction(PowerLaw{2.2}, 3),
        phase_correction(PowerLaw{0.8}, 3), phase_correction(PowerLaw{3.4}, 4),
        phase_correction(PowerLaw{1.3}, 6), phase_correction(PowerLaw{2.2}, 9)}) {
    const int steps = correction.steps;
    const auto frames = hard_frames<std::uint8_t>(steps, size, 8, 11);
    const auto reconstruct =
        fused(size, PhaseMeasuring{.steps = steps, .frequency = 1}, Axis::x, {{steps, correction}});
    const Maps decoding = maps_of(*reconstruct, FrameSet(frames));
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const PhaseSample measured = by_equations(frames, 0, steps, column, row);
        if (measured.modulation < 1e-9) continue;
        const float phase = decoding.wrapped_phase(column, row);
        ASSERT_TRUE(phase >= 0 && phase < 2 * std::numbers::pi) << phase;
        ASSERT_LE(apart_on_circle(phase, corrected_phase(correction, measured.wrapped_phase)),
                  phase_bound * (1 + steepest(correction)));
      }
    }
  }
}

TEST_P(FusedPhase, IsCorrectedForUnevenShifts) {
  const OnlyVectorTarget only(GetParam());
  const Size size{33, 24};
  const Strategy strategy = PhaseMeasuring{.angles = {0, 45, 120, 200, 310}};
  const PhaseCorrections corrections = phase_corrections(PowerLaw{1.6}, strategy.layout());
  const FrameSet frames(hard_frames<std::uint8_t>(5, size, 8, 11));
  const Maps decoding = maps_of(*fused(size, strategy, Axis::x, corrections), frames);
  const PhaseMaps expected =
      PhaseDecoder(PhaseMethod::equation, {}, corrections)(frames, strategy.layout().bands.front());
  for (std::size_t i = 0; i < expected.mean.pixel_count(); ++i) {
    EXPECT_NEAR(decoding.mean.begin()[i], expected.mean.begin()[i], 1e-3);
    if (expected.modulation.begin()[i] < 1) continue;
    ASSERT_LE(apart_on_circle(decoding.wrapped_phase.begin()[i], expected.wrapped_phase.begin()[i]),
              phase_bound * (1 + steepest(corrections.at(1))));
  }
}

INSTANTIATE_TEST_SUITE_P(VectorTarget, FusedPhase, testing::ValuesIn(vector_targets()),
                         [](const auto& info) { return info.param; });

}  // namespace slipstream::fused_phase_test
