#include "decode/phase_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/phase_shifting.h"

namespace slipstream::equations_test {

using std::numbers::pi;

TEST(PhaseDecoder, PhaseEquationsGiveBackMeanModulationAndPhaseForAnyN) {
  for (const int N : {3, 4, 5, 6, 7, 8, 16, 31}) {
    const PhaseEquations decode(N);
    for (double phi = 0; phi < 2 * pi; phi += 0.05) {
      std::vector<double> I;
      for (int n = 0; n < N; ++n) I.push_back(120 + 80 * std::cos(phi - 2 * pi * n / N));
      const PhaseSample sample = decode(I);
      EXPECT_NEAR(sample.mean, 120, 1e-10);
      EXPECT_NEAR(sample.modulation, 80, 1e-10);
      EXPECT_NEAR(sample.wrapped_phase, phi, 1e-12);
    }
  }
}

TEST(PhaseDecoder, PhaseEquationsRefuseTooFewSteps) {
  EXPECT_THROW(PhaseEquations(2), Error);
}

TEST(PhaseDecoder, WrappedAngleStaysInTheCircleAndOffItsEnd) {
  EXPECT_EQ(wrapped_angle(-1e-14, 1), 0);
  EXPECT_EQ(wrapped_angle(0, 0), 0);
  EXPECT_NEAR(wrapped_angle(-1, 0), 1.5 * pi, 1e-15);
  EXPECT_NEAR(wrapped_angle(0, -1), pi, 1e-15);
  EXPECT_LT(wrapped_angle(-1e-9, 1), 2 * pi);
}

}  // namespace slipstream::equations_test

namespace slipstream::phase_correction_test {

constexpr double two_pi = 2 * std::numbers::pi;

PhaseCorrection of_sine(int steps, double amplitude) {
  PhaseCorrection correction{steps, {}};
  constexpr int count = 4096;
  for (int i = 0; i < count; ++i)
    correction.added.push_back(amplitude * std::sin(two_pi * i / count));
  return correction;
}

TEST(PhaseDecoder, PhaseCorrectionRepeatsNTimesAroundTheCircle) {
  for (const int steps : {3, 4, 5, 6}) {
    const PhaseCorrection correction = of_sine(steps, 0.1);
    for (double phi = 0.2; phi < two_pi - 0.2; phi += 0.001) {
      EXPECT_NEAR(corrected_phase(correction, phi), phi + 0.1 * std::sin(steps * phi), 1e-7);
    }
  }
}

TEST(PhaseDecoder, PhaseCorrectionStaysOnTheCircle) {
  const PhaseCorrection up{3, {0.1}};
  const PhaseCorrection down{3, {-0.1}};
  EXPECT_NEAR(corrected_phase(up, two_pi - 0.05), 0.05, 1e-12);
  EXPECT_NEAR(corrected_phase(down, 0.05), two_pi - 0.05, 1e-12);
  EXPECT_LT(corrected_phase({4, {-1e-18}}, 0), two_pi);
}

TEST(PhaseDecoder, PhaseCorrectionIsRefusedWhereItIsNone) {
  EXPECT_NO_THROW(require_valid(PhaseCorrection{3, {0}}, 3));
  EXPECT_THROW(require_valid(PhaseCorrection{3, {}}, 3), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{3, {0}}, 4), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{2, {0}}, 2), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{3, {std::numeric_limits<double>::infinity()}}, 3),
               Error);
}

}  // namespace slipstream::phase_correction_test

// Every (U, V) that 8-bit frames reach: tables and closed forms against the equations in double.

namespace slipstream::phase_tables_test {

constexpr int full_scale = 255;

bool is_grey_level(int value) {
  return value >= 0 && value <= full_scale;
}

/// Two grey levels whose difference is that.
std::optional<std::array<int, 2>> levels_apart(int difference) {
  if (std::abs(difference) > full_scale) return std::nullopt;
  return std::array{std::max(difference, 0), std::max(-difference, 0)};
}

/// Some intensities that give (U, V), or nothing where none do.
std::optional<std::vector<double>> intensities_for(int steps, int U, int V) {
  const bool same_parity = (U + V) % 2 == 0;
  if (steps == 4) {
    const auto a = levels_apart(U), b = levels_apart(V);
    return std::vector<double>{double((*a)[0]), double((*b)[0]), double((*a)[1]), double((*b)[1])};
  }
  if (!same_parity) return std::nullopt;
  const int half = (U + V) / 2;
  if (steps == 3) {
    // I_1 = V + I_2 and I_0 = (U + V) / 2 + I_2, with the least I_2 that keeps both from below 0.
    const int I_2 = std::max({0, -V, -half});
    if (!is_grey_level(I_2) || !is_grey_level(I_2 + V) || !is_grey_level(I_2 + half)) return {};
    return std::vector<double>{double(half + I_2), double(V + I_2), double(I_2)};
  }
  // With a = I_1 - I_4, b = I_2 - I_5, c = I_0 - I_3: V = a + b, U = 2 c + a - b.
  const int a =
      std::clamp(half, std::max(-full_scale, V - full_scale), std::min(full_scale, V + full_scale));
  const auto A = levels_apart(a), B = levels_apart(V - a), C = levels_apart(half - a);
  if (!A || !B || !C) return std::nullopt;
  return std::vector<double>{double((*C)[0]), double((*A)[0]), double((*B)[0]),
                             double((*C)[1]), double((*A)[1]), double((*B)[1])};
}

class PhaseDecoderTables : public testing::TestWithParam<int> {};

TEST_P(PhaseDecoderTables, EqualTheEquationsAtEveryReachableIndex) {
  const int N = GetParam();
  const PhaseTables tables(N);
  const PhaseEquations equations(N);
  long reachable = 0;
  double worst_modulation = 0, worst_phase = 0;
  for (int V = -tables.largest_V(); V <= tables.largest_V(); ++V) {
    for (int U = -tables.largest_U(); U <= tables.largest_U(); ++U) {
      const auto I = intensities_for(N, U, V);
      if (!I) continue;
      ++reachable;
      const auto index = table_index<int>(tables.form(), std::span<const double>(*I));
      ASSERT_EQ(index.U, U);
      ASSERT_EQ(index.V, V);
      const PhaseSample exact = equations(*I);
      worst_modulation = std::max(worst_modulation, std::abs(tables.mlut(U, V) - exact.modulation));
      worst_phase = std::max(worst_phase, std::abs(tables.plut(U, V) - exact.wrapped_phase));
    }
  }
  EXPECT_LE(worst_modulation, 1e-12);
  EXPECT_LE(worst_phase, 1e-12);
  RecordProperty("reachable", std::to_string(reachable));
  // N = 4 reaches all of its square; 3 and 6 reach a hexagon of 3 n (n + 1) + 1 indices, n = 255
  // and 510.
  const long table = (2L * tables.largest_U() + 1) * (2L * tables.largest_V() + 1);
  EXPECT_EQ(reachable, N == 4 ? table : N == 3 ? 195841 : 781831);
}

INSTANTIATE_TEST_SUITE_P(N, PhaseDecoderTables, testing::Values(3, 4, 6));

TEST(PhaseDecoder, PhaseTablesRefuseOtherN) {
  EXPECT_THROW(PhaseTables(5), Error);
  EXPECT_EQ(closed_form(8), nullptr);
}

}  // namespace slipstream::phase_tables_test

namespace slipstream::phase_decoder_test {

/// Frames of random grey levels: any are possible to a decoder.
template <class Pixel>
std::vector<Image<Pixel>> random_images(int count, int full_scale) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> grey_level(0, full_scale);
  std::vector<Image<Pixel>> images;
  for (int n = 0; n < count; ++n) {
    images.emplace_back(Size{37, 11});
    for (Pixel& pixel : images.back()) pixel = static_cast<Pixel>(grey_level(random));
  }
  return images;
}

void expect_equal_maps(const PhaseMaps& a, const PhaseMaps& b) {
  for (std::size_t i = 0; i < a.mean.pixel_count(); ++i) {
    ASSERT_NEAR(a.mean.begin()[i], b.mean.begin()[i], 1e-9);
    ASSERT_NEAR(a.modulation.begin()[i], b.modulation.begin()[i], 1e-9);
    ASSERT_NEAR(a.wrapped_phase.begin()[i], b.wrapped_phase.begin()[i], 1e-12);
  }
}

TEST(PhaseDecoder, IntensityRatioGivesThePhaseOfThreeSteps) {
  const FrameSet frames(random_images<std::uint8_t>(3, 255));
  const PhaseMaps exact = PhaseDecoder(PhaseMethod::equation, {3})(frames, 0, 3);
  const PhaseDecoder by_ratio(PhaseMethod::intensity_ratio, {3});
  EXPECT_EQ(by_ratio.method_for(3, frames), PhaseMethod::intensity_ratio);
  EXPECT_EQ(by_ratio.method_for(4, frames), PhaseMethod::equation);
  const PhaseMaps maps = by_ratio(frames, 0, 3);
  for (std::size_t i = 0; i < maps.mean.pixel_count(); ++i) {
    const double apart = maps.wrapped_phase.begin()[i] - exact.wrapped_phase.begin()[i];
    ASSERT_NEAR(std::remainder(apart, 6.283185307179586), 0, 2e-8);
    ASSERT_EQ(maps.modulation.begin()[i], exact.modulation.begin()[i]);
  }
}

TEST(PhaseDecoder, MethodsAgreeOnEightBits) {
  for (const int N : {3, 4, 6}) {
    const FrameSet frames(random_images<std::uint8_t>(N + 2, 255));
    const PhaseMaps exact = PhaseDecoder(PhaseMethod::equation, {N})(frames, 1, N);
    expect_equal_maps(PhaseDecoder(PhaseMethod::closed_form, {N})(frames, 1, N), exact);
    expect_equal_maps(PhaseDecoder(PhaseMethod::tables, {N})(frames, 1, N), exact);
  }
}

TEST(PhaseDecoder, ClosedFormsTakeTwelveBits) {
  const FrameSet frames(random_images<std::uint16_t>(6, 4095), 12);
  const PhaseDecoder decode(PhaseMethod::closed_form, {6});
  EXPECT_EQ(decode.method_for(6, frames), PhaseMethod::closed_form);
  expect_equal_maps(decode(frames, 0, 6), PhaseDecoder(PhaseMethod::equation, {6})(frames, 0, 6));
}

TEST(PhaseDecoder, SaysWhereItFallsBackToTheEquations) {
  const FrameSet eight_bits(random_images<std::uint8_t>(8, 255));
  const FrameSet twelve_bits(random_images<std::uint16_t>(3, 4095), 12);
  const PhaseDecoder decode(PhaseMethod::tables, {3, 5});
  EXPECT_EQ(decode.method_for(3, eight_bits), PhaseMethod::tables);
  EXPECT_EQ(decode.method_for(5, eight_bits), PhaseMethod::equation);
  EXPECT_EQ(decode.method_for(3, twelve_bits), PhaseMethod::equation);
  const FrameSet eight_bits_in_sixteen(FrameSet::Images16(3, Image<std::uint16_t>({4, 3})), 8);
  EXPECT_EQ(decode.method_for(3, eight_bits_in_sixteen), PhaseMethod::equation);
  expect_equal_maps(decode(eight_bits, 0, 5),
                    PhaseDecoder(PhaseMethod::equation, {5})(eight_bits, 0, 5));
}

TEST(PhaseDecoder, CorrectsThePhaseInEveryMethod) {
  const FrameSet frames(random_images<std::uint8_t>(9, 255));
  PhaseCorrections corrections;
  for (const int N : {3, 4, 6}) corrections[N] = {N, {0, 0.02, 0.01, -0.01, -0.02}};
  for (const int N : {3, 4, 6, 5}) {
    const PhaseMaps plain = PhaseDecoder(PhaseMethod::equation, {N})(frames, 0, N);
    for (const PhaseMethod method :
         {PhaseMethod::equation, PhaseMethod::closed_form, PhaseMethod::tables}) {
      const PhaseMaps maps = PhaseDecoder(method, {N}, corrections)(frames, 0, N);
      for (std::size_t i = 0; i < maps.mean.pixel_count(); ++i) {
        const double phi = plain.wrapped_phase.begin()[i];
        const double wanted =
            corrections.contains(N) ? corrected_phase(corrections.at(N), phi) : phi;
        ASSERT_NEAR(std::remainder(maps.wrapped_phase.begin()[i] - wanted, 6.283185307179586), 0,
                    1e-12);
        ASSERT_NEAR(maps.modulation.begin()[i], plain.modulation.begin()[i], 1e-9);
      }
    }
  }
}

TEST(PhaseDecoder, OfABandIsThatOfItsFrames) {
  const FrameSet frames(random_images<std::uint8_t>(9, 255));
  PhaseCorrections corrections;
  corrections[4] = {4, {0, 0.02, 0.01, -0.01, -0.02}};
  for (const PhaseMethod method :
       {PhaseMethod::equation, PhaseMethod::closed_form, PhaseMethod::tables}) {
    const PhaseDecoder decode(method, {4, 5}, corrections);
    for (const auto& [first, N] : {std::pair{0, 4}, {3, 4}, {5, 4}, {2, 5}}) {
      const Band band = phase_shifted_band(9, first, N, 16);
      EXPECT_EQ(decode.method_for(band, frames), decode.method_for(N, frames));
      expect_equal_maps(decode(frames, band), decode(frames, first, N));
    }
    // The second channel is no run of steps: equations, and no correction.
    const Band second = phase_shifted_band(9, 2, 5, 1, 2);
    EXPECT_EQ(decode.method_for(second, frames), PhaseMethod::equation);
    const PhaseMaps maps = decode(frames, second);
    const Image<double> C = weighted_sum(frames, second.cosine),
                        S = weighted_sum(frames, second.sine);
    for (std::size_t i = 0; i < maps.mean.pixel_count(); ++i) {
      const double B = maps.modulation.begin()[i], phi = maps.wrapped_phase.begin()[i];
      ASSERT_NEAR(B * std::cos(phi), C.begin()[i], 1e-9);
      ASSERT_NEAR(B * std::sin(phi), S.begin()[i], 1e-9);
    }
  }
}

TEST(PhaseDecoder, RefusesACorrectionForAnotherN) {
  EXPECT_THROW(PhaseDecoder(PhaseMethod::tables, {3}, {{3, {4, {0}}}}), Error);
}

}  // namespace slipstream::phase_decoder_test
