#include "tools/reproduce/variance_ratio_tables.h"

#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/phase_channel_multiplexing.h"
#include "slipstream/codes/phase_shifting.h"
#include "slipstream/codes/strategy.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {
namespace {

constexpr PatternLight light{.alpha_p = 200, .beta_p = 55};

std::vector<VarianceRatioCell> printed_variance_table(int steps) {
  const auto cells = [&](std::array<double, 3> c1, std::array<double, 3> high,
                         std::array<double, 9> ratios) {
    std::vector<VarianceRatioCell> table;
    for (std::size_t i = 0; i < 9; ++i) {
      const double f_h = high[i % 3], share = c1[i / 3];
      table.push_back({.steps = steps,
                       .high = f_h,
                       .c1 = share,
                       .published = ratios[i],
                       .predicted = share * share * f_h * f_h});
    }
    return table;
  };
  switch (steps) {
    case 4:
      return cells({0.5, 0.6, 0.7}, {4, 6, 8},
                   {3.47, 7.04, 12.88, 4.89, 9.77, 20.41, 7.39, 12.98, 25.93});
    case 5:
      return cells({0.5, 0.6, 0.8}, {6, 8, 12},
                   {8.35, 15.27, 32.87, 12.01, 20.61, 41.94, 21.33, 36.86, 73.70});
    default:
      throw Error(fmt::format("{} steps have no table of variance ratios; 4 and 5 have", steps));
  }
}

/// Variance of decoded less true y over the pixels that are lit and unwrapped rightly.
double measured_variance(const Strategy& strategy, const FrameSet& frames,
                         const Image<double>& truth, int length, const CueSettings& cue) {
  const BasicMaps<double> maps =
      Decoder(strategy.layout(), length, PhaseMethod::tables, {}, cue)(frames);
  double sum = 0, squares = 0, count = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double error = maps.coordinate.begin()[i] - truth.begin()[i];
    if (!(std::abs(error) < 0.5 / highest_frequency(strategy))) continue;
    sum += error;
    squares += error * error;
    ++count;
  }
  return squares / count - sum * sum / (count * count);
}

/// Variance of PMP over that of each cell's PCMP, for frames taken with that photometry.
std::vector<double> measured_ratios(const std::vector<VarianceRatioCell>& table, Size camera,
                                    Photometry photometry) {
  const Scanner scanner = example_scanner(camera);
  const int length = scanner.projector.size.width, steps = table.front().steps;
  const CueSettings cue{.light = light, .ambient = photometry.ambient};
  const Strategy unit = PhaseMeasuring{.steps = steps, .frequency = 1};
  const VirtualScan board = take_scan(scanner, scene_named("board", scanner),
                                      pattern_set(unit, Axis::x, light), photometry);
  const double unit_variance = measured_variance(unit, board.frames, board.coordinate, length, cue);
  std::vector<double> ratios;
  for (const VarianceRatioCell& cell : table) {
    const Strategy strategy = PhaseChannelMultiplexing{
        .steps = steps, .high = cell.high, .share = cell.c1, .reference = {}};
    ++photometry.seed;
    const FrameSet frames = take_again(board, pattern_set(strategy, Axis::x, light), photometry);
    ratios.push_back(unit_variance /
                     measured_variance(strategy, frames, board.coordinate, length, cue));
  }
  return ratios;
}

}  // namespace

std::vector<VarianceRatioCell> variance_ratio_table(int steps, const VarianceRatioTrial& trial) {
  std::vector<VarianceRatioCell> table = printed_variance_table(steps);
  Photometry photometry;
  photometry.ambient = -7;
  photometry.noise_variance = 1.55;
  photometry.seed = trial.seed * 1000;
  const std::vector<double> ideal = measured_ratios(table, trial.camera, photometry);
  photometry.response = PowerLaw{trial.gamma};
  photometry.physics.translucency = trial.translucency;
  const std::vector<double> foam = measured_ratios(table, trial.camera, photometry);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i].measured = ideal[i];
    table[i].of_foam = foam[i];
  }
  return table;
}

}  // namespace slipstream
