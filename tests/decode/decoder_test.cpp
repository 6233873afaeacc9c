#include "decode/decoder.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "codes/predicted_variance.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/strategy.h"

namespace slipstream::decoder_test {

/// Frames of a flat thing that the camera sees at the same scale as the projector shows it: column
/// i has coordinate `coordinate(i)`.
template <class Coordinate>
FrameSet frames_of(const Strategy& strategy, int columns, const Coordinate& coordinate,
                   double noise = 0) {
  const PatternSet patterns = pattern_set(strategy, Axis::x, {.alpha_p = 200, .beta_p = 20});
  std::mt19937 random(3);
  std::normal_distribution<double> w(0, 1);
  FrameSet::ImagesUnquantised images;
  for (int n = 0; n < patterns.count; ++n) {
    images.emplace_back(Size{columns, 1});
    for (int i = 0; i < columns; ++i) {
      images.back()(i, 0) = 0.7 * patterns.intensity(n, coordinate(i)) + noise * w(random);
    }
  }
  return FrameSet(std::move(images));
}

RC_GTEST_PROP(Decoder, GivesTheCoordinateThatWasShown, ()) {
  const int steps = *rc::gen::inRange(3, 12);
  const int low_steps = *rc::gen::inRange(3, 12);
  const double low = *rc::gen::element(1.0, 0.5);
  const double high = low * *rc::gen::inRange(1, 40);
  const Strategy strategy =
      DualFrequency{.steps = steps, .low_steps = low_steps, .high = high, .low = low};
  constexpr int length = 500;
  const auto exact = [](int i) { return (i - 0.49) / length; };
  const BasicMaps<double> decoded =
      Decoder(strategy.layout(), length, PhaseMethod::equation)(frames_of(strategy, length, exact));
  for (int i = 0; i < length; ++i) {
    RC_ASSERT(std::abs(decoded.coordinate(i, 0) - exact(i)) < 1e-12);
  }
}

TEST(Decoder, GivesTheCoordinateByEveryWayOfUnwrapping) {
  constexpr int length = 500;
  const auto exact = [](int i) { return (i - 0.4) / length; };
  for (const Strategy& strategy :
       {Strategy(MultiFrequency{.steps = {3}, .periods = {25, 20, 22}, .unwrapping = "heterodyne"}),
        Strategy(MultiFrequency{.steps = {4, 3, 3}, .periods = {9.6, 11.3, 10.5}}),
        Strategy(MultiFrequency{.steps = {3}, .periods = {13, 15}, .unwrapping = "number-theory"}),
        Strategy(MicroPhaseShifting{.periods = {25, 23, 22, 19}}),
        Strategy(GrayPhase{.steps = 5, .periods = 12, .reference = "inverse"})}) {
    const BasicMaps<double> decoded = Decoder(
        strategy.layout(), length, PhaseMethod::equation)(frames_of(strategy, length, exact));
    for (int i = 0; i < length; ++i) {
      ASSERT_NEAR(decoded.coordinate(i, 0), exact(i), 1e-6) << strategy.name() << ", " << i;
    }
  }
}

TEST(Decoder, FringeOrderIsRightUnderNoiseUpToTheEndsOfTheField) {
  // Noise of the low frequency carries its phase across 0 = 2 pi at both ends; no pixel may come
  // out at the wrong end or a fringe away. 20,000 pixels, among them every projector column's
  // centre.
  constexpr int length = 1000, columns = 20000;
  const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
  const auto exact = [](int i) { return static_cast<double>(i % length) / length; };
  const FrameSet frames = frames_of(strategy, columns, exact, std::sqrt(1.55));
  const BasicMaps<double> decoded =
      Decoder(strategy.layout(), length, PhaseMethod::equation)(frames);
  const double sigma = std::sqrt(coordinate_variance(strategy.layout(), 0.7 * 200 / 2, 1.55));
  for (int i = 0; i < columns; ++i) {
    ASSERT_NEAR(decoded.coordinate(i, 0), exact(i), 6 * sigma) << "projector column " << i % length;
  }
}

// Of a projector's pixels, which stripes need not be whole.
TEST(Decoder, GivesTheMiddleOfTheStripesPixels) {
  constexpr int length = 500;
  for (const double stripes : {500.0, 400.0, 333.3, 256.0, 125.0, 40.0}) {
    const Code& code = *Strategy(GrayCode{.bits = 9, .stripes = stripes}).layout().code;
    const auto pixel = [](int i) { return static_cast<double>(i) / length; };
    const BasicMaps<double> decoded = Decoder(
        Strategy(GrayCode{.bits = 9, .stripes = stripes}).layout(), length,
        PhaseMethod::equation)(frames_of(GrayCode{.bits = 9, .stripes = stripes}, length, pixel));

    for (int i = 0; i < length; ++i) {
      const auto in_same_stripe = [&](int other) {
        return std::floor(pixel(other) * code.stripes + 1e-9) ==
               std::floor(pixel(i) * code.stripes + 1e-9);
      };
      int first = i, last = i;
      while (first > 0 && in_same_stripe(first - 1)) --first;
      while (last + 1 < length && in_same_stripe(last + 1)) ++last;

      // The last stripe may reach beyond the field.
      if (last + 1 < length) {
        EXPECT_NEAR(decoded.coordinate(i, 0) * length, (first + last) / 2.0, 1e-9) << stripes;
      }
    }
  }
}

TEST(Decoder, RefusesAnotherNumberOfFrames) {
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  const FrameSet three =
      frames_of(PhaseMeasuring{.steps = 3, .frequency = 1}, 10, [](int i) { return i / 10.0; });
  EXPECT_THROW(static_cast<void>(Decoder(strategy.layout(), 10, PhaseMethod::tables)(three)),
               Error);
}

TEST(Decoder, HasNoCoordinateForManyPeriodsAlone) {
  const Strategy strategy = PhaseMeasuring{.steps = 3, .frequency = 4};
  const FrameSet frames = frames_of(strategy, 100, [](int i) { return i / 100.0; });
  const BasicMaps<double> decoded = Decoder(strategy.layout(), 100, PhaseMethod::tables)(frames);
  EXPECT_TRUE(decoded.coordinate.empty());
  EXPECT_FALSE(decoded.wrapped_phase.empty());
}

TEST(Decoder, SaysWhichMethodDecodes) {
  FrameSet::Images8 images(8, Image<std::uint8_t>({4, 4}));
  const Strategy mixed = DualFrequency{.steps = 5, .low_steps = 3};
  EXPECT_EQ(Decoder(mixed.layout(), 100, PhaseMethod::tables).method_for(FrameSet(images)),
            "equation, lut");
  const Strategy tabled = DualFrequency{.steps = 4};
  EXPECT_EQ(Decoder(tabled.layout(), 100, PhaseMethod::tables).method_for(FrameSet(images)), "lut");
}

}  // namespace slipstream::decoder_test
