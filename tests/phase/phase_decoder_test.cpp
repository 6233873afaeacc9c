#include "slipstream/phase/phase_decoder.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

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

TEST(PhaseDecoder, BackendsAgreeOnEightBits) {
  for (const int N : {3, 4, 6}) {
    const FrameSet frames(random_images<std::uint8_t>(N + 2, 255));
    const PhaseMaps exact = PhaseDecoder(Backend::equation, {N})(frames, 1, N);
    expect_equal_maps(PhaseDecoder(Backend::closed_form, {N})(frames, 1, N), exact);
    expect_equal_maps(PhaseDecoder(Backend::lut, {N})(frames, 1, N), exact);
  }
}

TEST(PhaseDecoder, ClosedFormsTakeTwelveBits) {
  const FrameSet frames(random_images<std::uint16_t>(6, 4095), 12);
  const PhaseDecoder decode(Backend::closed_form, {6});
  EXPECT_EQ(decode.backend_for(6, frames), Backend::closed_form);
  expect_equal_maps(decode(frames, 0, 6), PhaseDecoder(Backend::equation, {6})(frames, 0, 6));
}

TEST(PhaseDecoder, SaysWhereItFallsBackToTheEquations) {
  const FrameSet eight_bits(random_images<std::uint8_t>(8, 255));
  const FrameSet twelve_bits(random_images<std::uint16_t>(3, 4095), 12);
  const PhaseDecoder decode(Backend::lut, {3, 5});
  EXPECT_EQ(decode.backend_for(3, eight_bits), Backend::lut);
  EXPECT_EQ(decode.backend_for(5, eight_bits), Backend::equation);
  EXPECT_EQ(decode.backend_for(3, twelve_bits), Backend::equation);
  const FrameSet eight_bits_in_sixteen(FrameSet::Images16(3, Image<std::uint16_t>({4, 3})), 8);
  EXPECT_EQ(decode.backend_for(3, eight_bits_in_sixteen), Backend::equation);
  expect_equal_maps(decode(eight_bits, 0, 5),
                    PhaseDecoder(Backend::equation, {5})(eight_bits, 0, 5));
}

TEST(PhaseDecoder, CorrectsThePhaseInEveryBackend) {
  const FrameSet frames(random_images<std::uint8_t>(9, 255));
  PhaseCorrections corrections;
  for (const int N : {3, 4, 6}) corrections[N] = {N, {0, 0.02, 0.01, -0.01, -0.02}};
  for (const int N : {3, 4, 6, 5}) {
    const PhaseMaps plain = PhaseDecoder(Backend::equation, {N})(frames, 0, N);
    for (const Backend backend : {Backend::equation, Backend::closed_form, Backend::lut}) {
      const PhaseMaps maps = PhaseDecoder(backend, {N}, corrections)(frames, 0, N);
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

TEST(PhaseDecoder, RefusesACorrectionForAnotherN) {
  EXPECT_THROW(PhaseDecoder(Backend::lut, {3}, {{3, {4, {0}}}}), Error);
}

TEST(Backend, HasNames) {
  for (const Backend backend : {Backend::equation, Backend::closed_form, Backend::lut}) {
    EXPECT_EQ(backend_named(name_of(backend)), backend);
  }
  EXPECT_THROW(backend_named("fast"), Error);
}

}  // namespace
}  // namespace slipstream
