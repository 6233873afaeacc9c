#include "slipstream/decode/phase_decoder.h"

#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/frames/frame_set.h"

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
