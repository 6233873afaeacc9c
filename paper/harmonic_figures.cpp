#include "paper/harmonic_figures.h"

#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"
#include "paper/formulas.h"
#include "response/harmonics.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

constexpr double gamma_of_figures = 2.2;

Reproduction figure_143(std::uint64_t /*seed*/) {
  PlotLine ideal{"ideal"}, distorted{"gamma 2.2"}, magnitudes{""};
  for (int i = 0; i <= 400; ++i) {
    const double phi = 4 * std::numbers::pi * i / 400, value = (1 + std::cos(phi)) / 2;
    ideal.add(phi, 255 * value);
    distorted.add(phi, 255 * std::pow(value, gamma_of_figures));
  }
  Reproduction result;
  const double B_1 = harmonic(gamma_of_figures, 1);
  for (int k = 0; k <= 6; ++k) {
    const double B_k = std::abs(harmonic(gamma_of_figures, k)) / (k == 0 ? 2 : 1);
    magnitudes.add(k, 255 * B_k);
    result.add("magnitude of the harmonic over the first", {{"harmonic", double(k)}}, {},
               B_k / B_1);
  }
  result.draw("figure-1.43-wave", "A sine wave and its distortion by gamma 2.2", "phi, rad",
              "grey levels", PlotScale::linear, {ideal, distorted});
  result.draw("figure-1.43-spectrum", "Magnitudes of its harmonics", "harmonic", "grey levels",
              PlotScale::logarithmic, {magnitudes});
  result.notes.emplace_back("The figure is printed without numbers.");
  return result;
}

/// Magnitude or phase of the first three harmonics on a white board.
Reproduction board_figure(const char* figure, bool phase, std::uint64_t seed) {
  constexpr int steps = 8;
  const Scanner scanner = example_scanner({320, 240});
  const VirtualScan scan = take_scan(
      scanner, scene_named("board", scanner), pattern_set(PhaseMeasuring{steps, 1}, Axis::x),
      {.ambient = 5, .response = PowerLaw{gamma_of_figures}, .noise_variance = 1.55, .seed = seed});
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(scan.frames, 0, steps);
  Reproduction result;
  for (int k = 1; k <= 3; ++k) {
    Image<double> map(pixels.size()), ratios(pixels.size());
    for (std::size_t i = 0; i < map.pixel_count(); ++i) {
      const MeasuredHarmonics& at = pixels.begin()[i];
      const std::complex<double> value = k == 1 ? at.fundamental : k == 2 ? at.second : at.third;
      const bool lit = !std::isnan(scan.coordinate.begin()[i]);
      map.begin()[i] = !lit ? std::nan("") : phase ? std::arg(value) : std::abs(value);
      ratios.begin()[i] = lit ? std::abs(value) / at.B_1() : std::nan("");
    }
    if (k > 1 && !phase) {
      result.add("magnitude of the harmonic over the first, median", {{"harmonic", double(k)}},
                 harmonic_ratios(gamma_of_figures, k).back(), median(finite_values(ratios)));
    }
    result.draw_map(fmt::format("figure-{}-{}", figure, k), map, phase ? "rad" : "grey levels");
  }
  result.notes.emplace_back(
      "A virtual board under 8 steps, gamma 2.2. The text has three steps, which cannot separate "
      "these harmonics: they fold the second onto the first and the third onto the mean.");
  if (!phase) result.notes.emplace_back("Published: Eq. (4.14).");
  return result;
}

}  // namespace

std::vector<Reproducible> harmonic_reproducibles() {
  return {{"figure", "1.43", "a sine wave distorted by gamma", figure_143},
          {"figure", "1.44", "magnitude of harmonics on a board",
           [](std::uint64_t seed) { return board_figure("1.44", false, seed); }},
          {"figure", "1.45", "phase of harmonics on a board",
           [](std::uint64_t seed) { return board_figure("1.45", true, seed); }}};
}

}  // namespace slipstream
