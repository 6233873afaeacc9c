#include "paper/phase_figures.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"
#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "paper/multiplexing_tables.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

/// Variance of the phase of simulated pixels with N steps, a fringe modulation B and noise of
/// variance 2, rad^2.
double simulated_phase_variance(int steps, double modulation, std::uint64_t seed) {
  const Image<double> y = smooth_coordinate({320, 240});
  const double alpha = 2 * modulation / 255;
  const FrameSet frames =
      noisy_frames(pattern_set(PhaseMeasuring{steps, 1}, Axis::y, {.alpha_p = 255, .beta_p = 0}), y,
                   {.alpha = alpha, .beta = 0, .noise_variance = 2}, seed);
  const PhaseMaps maps = PhaseDecoder(PhaseMethod::equation, {steps})(frames, 0, steps);
  double squares = 0;
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    const double truth = 2 * std::numbers::pi * y.begin()[i];
    const double error =
        std::remainder(maps.wrapped_phase.begin()[i] - truth, 2 * std::numbers::pi);
    squares += error * error;
  }
  return squares / static_cast<double>(y.pixel_count());
}

Reproduction figure_127(std::uint64_t seed) {
  constexpr double noise = 2, usual_modulation = 50;
  constexpr int usual_steps = 4;
  Reproduction result;
  PlotLine by_steps{"simulated"}, by_modulation{"simulated"};
  PlotLine steps_predicted{"Eq. (1.16)"}, modulation_predicted{"Eq. (1.16)"};
  const auto add = [&](int steps, double modulation, double at, PlotLine& line,
                       PlotLine& predicted) {
    line.add(at, simulated_phase_variance(steps, modulation, ++seed));
    predicted.add(at, 2 * noise / (steps * modulation * modulation));  // (1.16)
    result.add("variance of the phase, rad^2", {{"N", steps}, {"B", modulation}},
               predicted.y.back(), line.y.back());
  };
  for (int steps = 3; steps <= 12; ++steps) {
    add(steps, usual_modulation, steps, by_steps, steps_predicted);
  }
  for (double modulation = 10; modulation <= 100; modulation += 10) {
    add(usual_steps, modulation, modulation, by_modulation, modulation_predicted);
  }
  result.draw("figure-1.27-steps", "Variance of the phase, B = 50, noise variance 2", "N", "rad^2",
              PlotScale::logarithmic, {by_steps, steps_predicted});
  result.draw("figure-1.27-modulation", "Variance of the phase, N = 4, noise variance 2", "B",
              "rad^2", PlotScale::logarithmic, {by_modulation, modulation_predicted});
  result.notes.emplace_back("Published: Eq. (1.16); the figure is printed without numbers.");
  return result;
}

Reproduction figure_128(std::uint64_t seed) {
  const DualFrequency dual{.steps = 4, .high = 16};
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = dual;
  const VirtualScan scan =
      take_scan(scanner, scene_named("board", scanner), pattern_set(strategy, Axis::x),
                {.ambient = 5, .noise_variance = 1.55, .seed = seed});
  const BasicMaps<double> maps = Decoder(strategy.layout(), scanner.projector.size.width,
                                         PhaseMethod::equation, {}, {})(scan.frames);

  Image<double> wrapped = maps.wrapped_phase, unwrapped = maps.coordinate;
  std::size_t lit = 0, correct = 0;
  for (std::size_t i = 0; i < wrapped.pixel_count(); ++i) {
    const double truth = scan.coordinate.begin()[i];
    if (std::isnan(truth)) {
      wrapped.begin()[i] = unwrapped.begin()[i] = std::nan("");
      continue;
    }
    ++lit;
    if (std::abs(unwrapped.begin()[i] - truth) < 0.5 / dual.high) ++correct;
    unwrapped.begin()[i] *= 2 * std::numbers::pi * dual.high;
  }

  PlotLine wrapped_row{"wrapped"}, unwrapped_row{"unwrapped"};
  for (int column = 0; column < wrapped.width(); ++column) {
    wrapped_row.add(column, wrapped(column, wrapped.height() / 2));
    unwrapped_row.add(column, unwrapped(column, wrapped.height() / 2));
  }
  Reproduction result;
  result.add("pixels unwrapped correctly, %", {{"f_h", dual.high}}, {},
             100 * static_cast<double>(correct) / static_cast<double>(lit));
  result.draw("figure-1.28-row", "Phases of the middle row", "column", "rad", PlotScale::linear,
              {wrapped_row, unwrapped_row});
  result.draw_map("figure-1.28-wrapped", std::move(wrapped), "rad");
  result.draw_map("figure-1.28-unwrapped", std::move(unwrapped), "rad");
  return result;
}

}  // namespace

std::vector<Reproducible> phase_reproducibles() {
  return {{"figure", "1.27", "noise of the phase by steps and modulation", figure_127},
          {"figure", "1.28", "wrapped and unwrapped phase of a board", figure_128}};
}

}  // namespace slipstream
