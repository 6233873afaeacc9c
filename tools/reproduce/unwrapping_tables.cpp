#include "tools/reproduce/unwrapping_tables.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/phase_channel_multiplexing.h"
#include "slipstream/codes/strategy.h"
#include "slipstream/decode/decoder.h"
#include "tools/reproduce/noisy_frames.h"

namespace slipstream {
namespace {

constexpr NoisyPixels pixels{.alpha = 0.5, .beta = -7, .noise_variance = 1.55};
constexpr int projector_length = 1140;

/// The cells as printed.
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
      throw Error(fmt::format("{} steps have no table of unwrapping; 3, 4 and 5 have", steps));
  }
}

/// 1 where the coordinate is within half a period of the truth.
Image<std::uint8_t> rightly_unwrapped(const Strategy& strategy, const FrameSet& frames,
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

void recompute(UnwrappingCell& cell, const Image<double>& y, std::uint64_t seed) {
  const Strategy strategy = PhaseChannelMultiplexing{
      .steps = cell.steps, .high = cell.high, .share = cell.c1, .reference = {}};
  CueSettings cue{.light = {.alpha_p = cell.alpha_p, .beta_p = 255 - cell.alpha_p},
                  .ambient = pixels.beta,
                  .noise_variance = pixels.noise_variance,
                  .rule = CueRule::published};
  const FrameSet frames = noisy_frames(pattern_set(strategy, Axis::y, cue.light), y, pixels, seed);
  const Image<std::uint8_t> published = rightly_unwrapped(strategy, frames, y, cue);
  cue.rule = CueRule::consensus;
  const Image<std::uint8_t> improved = rightly_unwrapped(strategy, frames, y, cue);

  const double percent = 100.0 / static_cast<double>(y.pixel_count());
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    cell.recomputed += percent * published.begin()[i];
    cell.improved += percent * improved.begin()[i];
    if (published.begin()[i] > improved.begin()[i]) ++cell.worse;
  }
}

}  // namespace

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
  for (UnwrappingCell& cell : table) recompute(cell, y, ++seed);
  return table;
}

}  // namespace slipstream
