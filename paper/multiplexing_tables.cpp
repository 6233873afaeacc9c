#include "paper/multiplexing_tables.h"

#include <array>
#include <cmath>
#include <optional>
#include <random>

#include <fmt/format.h>

#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

constexpr int projector_length = 1140;

/// The cells, as printed.
std::vector<UnwrappingCell> printed_unwrapping_table(int steps) {
  const auto cells = [&](std::array<double, 3> alpha_p, std::array<double, 3> c1,
                         std::array<double, 3> high, std::array<double, 9> percent) {
    std::vector<UnwrappingCell> table;
    for (std::size_t i = 0; i < 9; ++i) {
      table.push_back({.steps = steps,
                       .alpha_p = alpha_p[i / 3],
                       .high = high[i % 3],
                       .c1 = c1[i / 3],
                       .published = percent[i]});
    }
    return table;
  };
  switch (steps) {
    case 3:
      return cells({200, 220, 240}, {0.5, 0.5, 0.5}, {3, 4, 6},
                   {99.19, 96.28, 85.17, 99.76, 98.86, 92.44, 99.83, 99.67, 96.85});
    case 4:
      return cells({200, 200, 200}, {0.5, 0.6, 0.7}, {4, 6, 8},
                   {99.79, 98.65, 96.37, 99.80, 98.63, 96.30, 99.71, 98.15, 95.22});
    case 5:
      return cells({200, 200, 200}, {0.5, 0.6, 0.8}, {6, 8, 12},
                   {99.61, 99.61, 99.61, 99.50, 99.50, 99.49, 98.99, 98.95, 98.83});
    default:
      throw Error(fmt::format("no unwrapping table for {} steps; choose 3, 4 or 5", steps));
  }
}

/// 1 where the coordinate is within half a period of the truth.
Image<std::uint8_t> correctly_unwrapped(const Strategy& strategy, const FrameSet& frames,
                                        const Image<double>& y, const CueSettings& cue) {
  const BasicMaps<double> maps =
      Decoder(strategy.layout(), projector_length, PhaseMethod::equation, {}, cue)(frames);
  Image<std::uint8_t> right(y.size());
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    const double error = std::abs(maps.coordinate.begin()[i] - y.begin()[i]);
    right.begin()[i] = error < 0.5 / highest_frequency(strategy) ? 1 : 0;
  }
  return right;
}

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
    case 3:
      return {{.steps = 3, .high = 3, .c1 = 0.5, .published = 2.15, .predicted = 2.25}};
    case 4:
      return cells({0.5, 0.6, 0.7}, {4, 6, 8},
                   {3.47, 7.04, 12.88, 4.89, 9.77, 20.41, 7.39, 12.98, 25.93});
    case 5:
      return cells({0.5, 0.6, 0.8}, {6, 8, 12},
                   {8.35, 15.27, 32.87, 12.01, 20.61, 41.94, 21.33, 36.86, 73.70});
    default:
      throw Error(fmt::format("no table of variance ratios for {} steps; choose 3, 4 or 5", steps));
  }
}

/// Variance of decoded minus true y over the pixels that are lit and unwrapped correctly.
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

/// Variance of PMP divided by the variance of each cell's PCMP, for frames with this photometry.
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

constexpr auto smooth = UnwrappingTrial::Surface::smooth;
constexpr auto stepped = UnwrappingTrial::Surface::stepped;

ReproducedCell reproduced(const UnwrappingCell& cell, std::optional<double> published) {
  return {"pixels unwrapped correctly, %",
          {{"N", cell.steps}, {"alpha_p", cell.alpha_p}, {"c_1", cell.c1}, {"f_h", cell.high}},
          published,
          cell.recomputed,
          cell.improved};
}

Reproduction unwrapping(int steps, std::uint64_t seed) {
  Reproduction result;
  for (const UnwrappingCell& cell : unwrapping_table(steps, {.surface = smooth, .seed = seed})) {
    result.cells.push_back(reproduced(cell, cell.published));
  }
  return result;
}

Reproduction unwrapping_at_edges(std::uint64_t seed) {
  Reproduction result;
  std::size_t worse = 0;
  for (const int steps : {3, 4, 5}) {
    for (const UnwrappingCell& cell : unwrapping_table(steps, {.surface = stepped, .seed = seed})) {
      result.cells.push_back(reproduced(cell, std::nullopt));
      worse += cell.worse;
    }
  }
  result.notes.push_back(
      fmt::format("Of the pixels of all 27 scans {} are unwrapped correctly by the published rule "
                  "and incorrectly by the default one.",
                  worse));
  return result;
}

Reproduction variance_ratios(int steps, std::uint64_t seed) {
  const VarianceRatioTrial trial{.seed = seed};
  Reproduction result;
  std::vector<ReproducedCell> of_foam;
  for (const VarianceRatioCell& cell : variance_ratio_table(steps, trial)) {
    const auto add = [&](auto& cells, const char* quantity, double published, double recomputed) {
      cells.push_back({quantity,
                       {{"N", steps}, {"c_1", cell.c1}, {"f_h", cell.high}},
                       published,
                       recomputed,
                       {}});
    };
    add(result.cells, "variance of PMP over variance of PCMP", cell.predicted, cell.measured);
    add(of_foam, "the same, foam board", cell.published, cell.of_foam);
  }
  result.cells.insert(result.cells.end(), of_foam.begin(), of_foam.end());
  result.notes.emplace_back(
      "Published: the theory, c_1^2 f_h^2; recomputed: a board in the virtual scanner, 8-bit "
      "frames.");
  result.notes.push_back(fmt::format(
      "Foam board: published is the dissertation's experiment; recomputed with gamma {} and a "
      "board in which half of the light spreads by {} mm.",
      trial.gamma, trial.translucency));
  return result;
}

}  // namespace

void recompute(UnwrappingCell& cell, const Image<double>& y, const NoisyPixels& pixels,
               std::uint64_t seed) {
  const Strategy strategy = PhaseChannelMultiplexing{
      .steps = cell.steps, .high = cell.high, .share = cell.c1, .reference = {}};
  CueSettings cue{.light = {.alpha_p = cell.alpha_p, .beta_p = 255 - cell.alpha_p},
                  .ambient = -7,
                  .noise_variance = pixels.noise_variance,
                  .rule = CueRule::published};
  const FrameSet frames = noisy_frames(pattern_set(strategy, Axis::y, cue.light), y, pixels, seed);
  const Image<std::uint8_t> published = correctly_unwrapped(strategy, frames, y, cue);
  cue.rule = CueRule::consensus;
  const Image<std::uint8_t> improved = correctly_unwrapped(strategy, frames, y, cue);

  const double percent = 100.0 / static_cast<double>(y.pixel_count());
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    cell.recomputed += percent * published.begin()[i];
    cell.improved += percent * improved.begin()[i];
    if (published.begin()[i] > improved.begin()[i]) ++cell.worse;
  }
}

FrameSet noisy_frames(const PatternSet& patterns, const Image<double>& y, const NoisyPixels& pixels,
                      std::uint64_t seed) {
  const double alpha = pixels.alpha;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> w(0, std::sqrt(pixels.noise_variance));
  Image<double> ambient(y.size(), pixels.beta);
  if (pixels.ambient_variance > 0) {
    std::normal_distribution<double> spread(pixels.beta, std::sqrt(pixels.ambient_variance));
    for (double& beta : ambient) beta = spread(random);
  }
  FrameSet::ImagesUnquantised frames;
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& frame = frames.emplace_back(y.size());
    for (std::size_t i = 0; i < y.pixel_count(); ++i) {
      const double beta = ambient.begin()[i];
      frame.begin()[i] = alpha * (patterns.intensity(n, y.begin()[i]) + beta) + beta + w(random);
    }
  }
  return FrameSet(std::move(frames));
}

Image<double> smooth_coordinate(Size size) {
  Image<double> y(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) y(column, row) = (row + 0.5) / size.height;
  }
  return y;
}

Image<double> stepped_coordinate(Size size) {
  constexpr int across = 6, down = 4;
  constexpr double start = 0.08, rise = 0.6, offset = 0.013;
  Image<double> y(size);
  const double side_x = static_cast<double>(size.width) / across;
  const double side_y = static_cast<double>(size.height) / down;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const int tile_x = static_cast<int>(column / side_x);
      const int tile_y = static_cast<int>(row / side_y);
      const int tile = tile_y * across + tile_x;
      const double dx = (column + 0.5) / side_x - tile_x - 0.5;
      const double dy = (row + 0.5) / side_y - tile_y - 0.5;
      const std::array<bool, 3> covered{std::hypot(dx, dy) < 0.4,
                                        std::abs(dx) < 0.33 && std::abs(dy) < 0.33,
                                        std::abs(dx + dy) < 0.18};
      y(column, row) = start + rise * (row + 0.5) / size.height;
      if (covered[static_cast<std::size_t>(tile % 3)]) y(column, row) += offset * (tile + 1);
    }
  }
  return y;
}

std::vector<UnwrappingCell> unwrapping_table(int steps, const UnwrappingTrial& trial) {
  std::vector<UnwrappingCell> table = printed_unwrapping_table(steps);
  const bool smooth = trial.surface == UnwrappingTrial::Surface::smooth;
  const Image<double> y = smooth ? smooth_coordinate(trial.size) : stepped_coordinate(trial.size);
  std::uint64_t seed = trial.seed * 1000 + static_cast<std::uint64_t>(steps) * 100;
  for (UnwrappingCell& cell : table) recompute(cell, y, trial.pixels, ++seed);
  return table;
}

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

std::vector<Reproducible> multiplexing_table_reproducibles() {
  const auto unwrapping_of = [](int steps) {
    return [steps](std::uint64_t seed) { return unwrapping(steps, seed); };
  };
  const auto ratios_of = [](int steps) {
    return [steps](std::uint64_t seed) { return variance_ratios(steps, seed); };
  };
  return {{"table", "3.1", "pixels unwrapped correctly by 3-pattern PCMP", unwrapping_of(3)},
          {"table", "3.2", "pixels unwrapped correctly by 4-pattern PCMP", unwrapping_of(4)},
          {"table", "3.3", "pixels unwrapped correctly by 5-pattern PCMP", unwrapping_of(5)},
          {"section", "3.2", "pixels unwrapped correctly by PCMP with depth edges",
           unwrapping_at_edges},
          {"table", "3.5", "variance of 4-step PMP over variance of 4-pattern PCMP", ratios_of(4)},
          {"table", "3.7", "variance of 5-step PMP over variance of 5-pattern PCMP", ratios_of(5)}};
}

}  // namespace slipstream
