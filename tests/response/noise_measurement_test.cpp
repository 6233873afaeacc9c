// sigma_w^2 from virtual scans by each of the four measurements.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "codes/predicted_variance.h"
#include "decode/phase_decoder.h"
#include "response/noise_calibration.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::noise_measurement_test {

constexpr PatternLight light{.alpha_p = 200, .beta_p = 40};
constexpr int runs = 10;

/// A board in view of a scanner, scanned again and again with noise of another seed each time.
class Board {
 public:
  explicit Board(const Strategy& strategy, Photometry photometry)
      : patterns_(pattern_set(strategy, Axis::x, light)), photometry_(photometry) {
    const Scanner scanner = example_scanner({240, 180});
    first_ = take_scan(scanner, scene_named("board", scanner), patterns_, photometry);
    lit_ = Image<std::uint8_t>(first_.coordinate.size());
    std::transform(first_.coordinate.begin(), first_.coordinate.end(), lit_.begin(),
                   [](double y) { return static_cast<std::uint8_t>(std::isnan(y) ? 0 : 1); });
  }

  [[nodiscard]] FrameSet frames() {
    ++photometry_.seed;
    return take_again(first_, patterns_, photometry_);
  }
  [[nodiscard]] const Image<std::uint8_t>& lit() const { return lit_; }

 private:
  PatternSet patterns_;
  Photometry photometry_;
  VirtualScan first_;
  Image<std::uint8_t> lit_;
};

/// Mean of ten measurements over scans of N-step PMP at unit frequency.
template <class Measure>
double averaged(int steps, const Photometry& photometry, const Measure& measure) {
  Board board(PhaseMeasuring{.steps = steps, .frequency = 1}, photometry);
  double sum = 0;
  for (int run = 0; run < runs; ++run) sum += measure(board).variance;
  return sum / runs;
}

NoiseEstimate by_means(Board& board) {
  const auto mean = [&] { return weighted_sum(board.frames(), mean_weights(3)); };
  return noise_from_means(mean(), 3, mean(), 3, board.lit());
}
Image<double> b_cos(Board& board) {
  return weighted_sum(board.frames(), half_phase_weights());
}
NoiseEstimate by_half_phase(Board& board) {
  return noise_from_half_phase(b_cos(board), board.lit());
}
NoiseEstimate by_half_phases(Board& board) {
  return noise_from_half_phases(b_cos(board), b_cos(board), board.lit());
}

const Photometry linear{.ambient = 5, .noise_variance = 2, .bits = std::nullopt};
const Photometry bent{
    .ambient = 5, .response = PowerLaw{1.1}, .noise_variance = 2, .bits = std::nullopt};

TEST(NoiseMeasurement, IsRightWithinOnePercentOverTenRuns) {
  EXPECT_NEAR(averaged(3, linear, by_means), 2, 0.02);
  EXPECT_NEAR(averaged(4, linear, by_half_phase), 2, 0.02);
  EXPECT_NEAR(averaged(4, linear, by_half_phases), 2, 0.02);
}

TEST(NoiseMeasurement, OfTwoScansIsRightWhereGammaMisleadsThatOfOne) {
  EXPECT_GT(averaged(4, bent, by_half_phase), 2.2);
  EXPECT_NEAR(averaged(4, bent, by_half_phases), 2, 0.02);
  EXPECT_NEAR(averaged(3, bent, by_means), 2, 0.02);
}

TEST(NoiseMeasurement, ByMeansTakesScansOfAnyTwoStepCounts) {
  Board three(PhaseMeasuring{.steps = 3, .frequency = 1}, linear);
  Photometry other = linear;
  other.seed = 1000;
  Board five(PhaseMeasuring{.steps = 5, .frequency = 1}, other);
  double sum = 0;
  for (int run = 0; run < runs; ++run) {
    const Image<double> mean_3 = weighted_sum(three.frames(), mean_weights(3));
    const Image<double> mean_5 = weighted_sum(five.frames(), mean_weights(5));
    sum += noise_from_means(mean_3, 3, mean_5, 5, three.lit()).variance;
  }
  EXPECT_NEAR(sum / runs, 2, 0.02);
}

TEST(NoiseMeasurement, FromOneMultiplexedScanIsRightWithinTwoPercent) {
  for (const double c1 : {0.5, 0.6, 0.8}) {
    const Strategy strategy =
        PhaseChannelMultiplexing{.steps = 5, .high = 12, .share = c1, .reference = {}};
    Board board(strategy, {.ambient = 5, .noise_variance = 1.6, .bits = std::nullopt});
    double sum = 0;
    const PhaseDecoder decode(PhaseMethod::equation, {});
    const std::vector<Band>& channels = strategy.layout().bands;
    for (int run = 0; run < runs; ++run) {
      const FrameSet frames = board.frames();
      sum += noise_from_modulations(decode(frames, channels[0]).modulation,
                                    decode(frames, channels[1]).modulation, 5, c1, board.lit())
                 .variance;
    }
    EXPECT_NEAR(sum / runs / 1.6, 1, 0.02) << "c_1 " << c1;
  }
}

TEST(NoiseMeasurement, OfQuantisedFramesCountsTheRounding) {
  Photometry photometry = linear;
  photometry.bits = 8;
  EXPECT_NEAR(averaged(3, photometry, by_means), 2 + quantisation_variance, 0.02);
}

TEST(NoiseMeasurement, RefusesTooFewPixels) {
  const Image<double> image({20, 20});
  const Image<std::uint8_t> dark({20, 20});
  EXPECT_THROW(noise_from_half_phase(image, dark), Error);
}

TEST(NoiseMeasurement, TellsNoiseThatGrowsWithTheLight) {
  const double gain = 255.0 / 8000;
  const auto line_in = [&](const Photometry& photometry) {
    const Strategy strategy = make_strategy("pmp", {{"steps", 6}});
    Scanner scanner = example_scanner({240, 180});
    const PatternSet patterns = pattern_set(strategy, Axis::x, light);
    const VirtualScan scan =
        take_scan(scanner, scene_named("contrast", scanner), patterns, photometry);
    Photometry again = photometry;
    again.seed += 1;
    const FrameSet second = take_again(scan, patterns, again);
    const auto mean = [&](const FrameSet& frames) {
      return weighted_sum(frames, strategy.layout().bands.front().mean);
    };
    return noise_line_from_means(mean(scan.frames), mean(second), 6, unclipped_mask(scan.frames));
  };
  const NoiseLine grows = line_in({.ambient = 5, .physics = {.full_well = 8000, .read_noise = 20}});
  EXPECT_NEAR(grows.gain, gain, 5 * grows.gain_error);
  EXPECT_LT(grows.gain_error, 0.1 * gain);
  const double read = std::pow(20 * gain, 2) + quantisation_variance;
  EXPECT_NEAR(grows.at_half, 127.5 * gain + read, 0.15);
  const NoiseLine even = line_in({.ambient = 5, .noise_variance = 2});
  EXPECT_NEAR(even.gain, 0, 5 * even.gain_error);
}

}  // namespace slipstream::noise_measurement_test
