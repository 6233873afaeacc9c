#include "paper/gamma_model.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "decode/phase_decoder.h"
#include "paper/formulas.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"
#include "response/harmonics.h"
#include "slipstream/gamma.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Gamma of most figures in Chapter 4.
constexpr double paper_gamma = 3.18;

/// Line of y over evenly spaced x.
template <class Function>
PlotLine line_of(std::string label, double low, double high, int pieces, const Function& y) {
  PlotLine line{std::move(label)};
  for (int i = 0; i <= pieces; ++i) {
    const double x = low + (high - low) * i / pieces;
    line.add(x, y(x));
  }
  return line;
}

constexpr int circle_samples = 3000;

/// RMS over the circle of a function of the phase, at `circle_samples` phases.
template <class Function>
double rms_over_circle(const Function& f) {
  double sum = 0;
  for (int i = 0; i < circle_samples; ++i) {
    const double value = f(2 * pi * (i + 0.5) / circle_samples);
    sum += value * value;
  }
  return std::sqrt(sum / circle_samples);
}

double measured_in_circle(const Response& response, int steps, double phi) {
  const double measured = distorted_phase(response, steps, phi);
  return measured - 2 * pi * std::floor(measured / (2 * pi));
}

/// RMS error left after correction by a table.
double rms_left_by(const PhaseCorrection& correction, const Response& response) {
  return rms_over_circle([&](double phi) {
    const double measured = measured_in_circle(response, correction.steps, phi);
    return std::remainder(corrected_phase(correction, measured) - phi, 2 * pi);
  });
}

Reproduction table_41(std::uint64_t /*seed*/) {
  const Response response = PowerLaw{paper_gamma};
  const double table = rms_left_by(phase_correction(response, 3), response);
  Reproduction result;
  result.add("RMS phase error before correction, rad", {{"N", 3}, {"gamma", 3.18}}, 0.3033,
             rms_phase_error(response, 3));
  for (const auto& [highest, published] :
       {std::pair{2, 0.004}, {4, 3.7e-4}, {5, 2.9e-5}, {7, 6.2e-6}, {8, 1.8e-6}}) {
    const HarmonicRatios G = harmonic_ratios(paper_gamma, highest);
    const double rms = rms_over_circle(
        [&](double phi) { return true_phase(G, 3, distorted_phase(response, 3, phi)) - phi; });
    result.add("RMS phase error after correction, rad",
               {{"N", 3}, {"gamma", 3.18}, {"highest harmonic", highest}}, published, rms, table);
  }
  result.notes.emplace_back("Improved: slipstream's correction table, with all harmonics.");
  return result;
}

Reproduction figure_41(std::uint64_t /*seed*/) {
  std::vector<PlotLine> lines;
  for (int k = 1; k <= 4; ++k) {
    lines.push_back(line_of(fmt::format("B_{}", k), 1, 5, 200,
                            [&](double gamma) { return harmonic(gamma, k); }));
  }
  Reproduction result;
  result.draw("figure-4.1", "B_k, Eq. (4.9), alpha alpha_p = 1", "gamma", "B_k", PlotScale::linear,
              lines);
  return result;
}

Reproduction figure_42(std::uint64_t /*seed*/) {
  std::vector<PlotLine> lines;
  for (int k = 1; k <= 4; ++k) {
    lines.push_back(line_of(fmt::format("B_{} / B_{}", k + 1, k), 1, 5, 200,
                            [&](double gamma) { return (gamma - k) / (gamma + k + 1); }));
  }
  Reproduction result;
  result.draw("figure-4.2", "Ratios of neighbouring harmonics, Eq. (4.14)", "gamma", "B_k+1 / B_k",
              PlotScale::linear, lines);
  return result;
}

Reproduction figure_43(std::uint64_t /*seed*/) {
  Reproduction result;
  result.draw("figure-4.3", "Harmonics at gamma = 3.18", "k", "|B_k|", PlotScale::logarithmic,
              {line_of("", 1, 10, 9, [](double k) {
                return std::abs(harmonic(paper_gamma, static_cast<int>(std::lround(k))));
              })});
  return result;
}

Reproduction figure_44(std::uint64_t /*seed*/) {
  const Response response = PowerLaw{paper_gamma};
  std::vector<PlotLine> lines;
  Reproduction result;
  for (int steps = 3; steps <= 6; ++steps) {
    lines.push_back(line_of(fmt::format("N = {}", steps), 0, 2 * pi, 600,
                            [&](double phi) { return phase_error(response, steps, phi); }));
    result.add("RMS phase error, rad", {{"N", double(steps)}, {"gamma", paper_gamma}},
               steps == 3 ? std::optional(0.3033) : std::nullopt, rms_phase_error(response, steps),
               rms_left_by(phase_correction(response, steps), response));
  }
  result.draw("figure-4.4", "Phase error at gamma = 3.18, Eq. (4.45)", "phi, rad",
              "phi - measured phase, rad", PlotScale::linear, lines);
  return result;
}

Reproduction figure_45(std::uint64_t /*seed*/) {
  Reproduction result;
  result.draw("figure-4.5", "RMS phase error at gamma = 3.18", "N", "rad", PlotScale::logarithmic,
              {line_of("", 3, 40, 37, [](double steps) {
                return rms_phase_error(PowerLaw{paper_gamma}, static_cast<int>(std::lround(steps)));
              })});
  return result;
}

Reproduction figure_46(std::uint64_t /*seed*/) {
  std::vector<PlotLine> lines;
  for (int steps = 3; steps <= 6; ++steps) {
    lines.push_back(line_of(fmt::format("N = {}", steps), 1.005, 5.005, 400,
                            [&](double gamma) { return rms_phase_error(PowerLaw{gamma}, steps); }));
  }
  Reproduction result;
  result.draw("figure-4.6", "RMS phase error against gamma", "gamma", "rad", PlotScale::logarithmic,
              lines);
  result.notes.emplace_back(
      "The error is 0 at whole gamma up to N - 2; the plot does not sample these points.");
  return result;
}

Reproduction figure_47(std::uint64_t /*seed*/) {
  const Response response = PowerLaw{paper_gamma};
  PlotLine means{"computed"}, errors{""};
  Reproduction result;
  for (int steps = 5; steps <= 40; ++steps) {
    double mean = 0;
    const double rms = rms_over_circle([&](double phi) {
      const MeasuredHarmonics measured = measured_harmonics(response, steps, phi);
      const double gamma =
          gamma_from_harmonics(std::abs(measured.fundamental), std::abs(measured.second));
      mean += gamma / circle_samples;
      return gamma - paper_gamma;
    });
    means.add(steps, mean);
    errors.add(steps, rms);
    if (steps <= 8 || steps == 10 || steps == 12 || steps == 16 || steps == 20) {
      result.add("RMS error of gamma by Eq. (4.55)", {{"N", double(steps)}, {"gamma", paper_gamma}},
                 {}, rms);
    }
  }
  result.draw("figure-4.7-gamma", "Gamma by Eq. (4.55)", "N", "gamma", PlotScale::linear, {means});
  result.draw("figure-4.7-error", "RMS error of gamma by Eq. (4.55)", "N", "",
              PlotScale::logarithmic, {errors});
  result.notes.emplace_back("The figure is printed without numbers.");
  return result;
}

/// Figures 4.8 to 4.10: correction without calibration, no noise.
Reproduction blind_figure(const std::string& name, int steps, double gamma) {
  constexpr int count = 4000;
  const Response response = PowerLaw{gamma};
  Image<MeasuredHarmonics> pixels({count, 1});
  for (int i = 0; i < count; ++i) {
    MeasuredHarmonics& pixel = pixels(i, 0);
    pixel = measured_harmonics(response, steps, 2 * pi * i / count);
    pixel.mean *= 255;
    pixel.fundamental *= 255;
    pixel.second *= 255;
  }
  const BlindGamma found = find_gamma(pixels, Image<std::uint8_t>(pixels.size(), 1), steps);
  const PhaseCorrection correction = phase_correction(PowerLaw{found.gamma}, steps);
  const auto corrected = [&](double phi) {
    return corrected_phase(correction, measured_in_circle(response, steps, phi));
  };
  const auto left = [&](double phi) { return std::remainder(corrected(phi) - phi, 2 * pi); };

  Reproduction result;
  const std::vector<std::pair<std::string, double>> parameters{{"N", double(steps)},
                                                               {"gamma", gamma}};
  result.add("gamma found without calibration", parameters, gamma, found.gamma);
  result.add("RMS phase error before, rad", parameters, {}, rms_phase_error(response, steps));
  result.add("RMS phase error after, rad", parameters, {}, rms_over_circle(left));
  const auto line = [](const char* label, double from, const auto& y) {
    return line_of(label, from, 2 * pi - from, 600, y);
  };
  result.draw(name + "-phase", fmt::format("Phase, N = {}, gamma = {}", steps, gamma), "phi, rad",
              "rad", PlotScale::linear,
              {line("measured", 0.001,
                    [&](double phi) { return measured_in_circle(response, steps, phi); }),
               line("corrected", 0.001, corrected)});
  result.draw(name + "-error", fmt::format("Phase error, N = {}, gamma = {}", steps, gamma),
              "phi, rad", "rad", PlotScale::linear,
              {line("measured", 0, [&](double phi) { return -phase_error(response, steps, phi); }),
               line("corrected", 0.001, left)});
  return result;
}

}  // namespace

std::vector<Reproducible> gamma_model_reproducibles() {
  return {
      {"table", "4.1", "phase error left by a few harmonics", table_41},
      {"figure", "4.1", "coefficients B_k", figure_41},
      {"figure", "4.2", "ratios of coefficients", figure_42},
      {"figure", "4.3", "coefficients on a logarithmic scale", figure_43},
      {"figure", "4.4", "phase error around the circle", figure_44},
      {"figure", "4.5", "RMS phase error against N", figure_45},
      {"figure", "4.6", "RMS phase error against gamma", figure_46},
      {"figure", "4.7", "gamma from two harmonics against N", figure_47},
      {"figure", "4.8", "correction without calibration, N = 3",
       [](std::uint64_t) { return blind_figure("figure-4.8", 3, 3.18); }},
      {"figure", "4.9", "correction without calibration, N = 4",
       [](std::uint64_t) { return blind_figure("figure-4.9", 4, 6.36); }},
      {"figure", "4.10", "correction without calibration, N = 5",
       [](std::uint64_t) { return blind_figure("figure-4.10", 5, 10.36); }},
  };
}

}  // namespace slipstream
