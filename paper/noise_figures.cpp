#include "paper/noise_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "codes/predicted_variance.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "paper/formulas.h"
#include "paper/multiplexing_tables.h"
#include "response/noise_calibration.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

using std::numbers::pi;

constexpr Size picture{320, 240};

/// Variance of the values, without NaN.
double variance_of(const Image<double>& values) {
  double sum = 0, squares = 0, count = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    squares += value * value;
    ++count;
  }
  return squares / count - sum * sum / (count * count);
}

FrameSet frames_of(const Strategy& strategy, const PatternLight& light, const NoisyPixels& pixels,
                   std::uint64_t seed) {
  return noisy_frames(pattern_set(strategy, Axis::y, light), smooth_coordinate(picture), pixels,
                      seed);
}

/// Mean of ten measurements of sigma_w^2 = 2, and the printed one.
template <class Measure>
Reproduction ten_measurements(const char* figure, const char* equation, double published,
                              std::uint64_t seed, const Measure& measure) {
  PlotLine line;
  double sum = 0;
  for (int run = 1; run <= 10; ++run) {
    const double variance = measure(seed * 1000 + 2 * static_cast<std::uint64_t>(run));
    line.add(run, variance);
    sum += variance;
  }
  Reproduction result;
  result.add(fmt::format("sigma_w^2 by {}, mean of 10 measurements", equation),
             {{"sigma_w^2", 2.0}}, published, sum / 10);
  result.draw(fmt::format("figure-{}", figure),
              fmt::format("Noise variance measured by Eq. {}", equation), "measurement",
              "sigma_w^2", PlotScale::linear, {line});
  return result;
}

constexpr NoisyPixels of_variance_2{.alpha = 0.5, .beta = -7, .noise_variance = 2};
constexpr PatternLight published_light{.alpha_p = 200, .beta_p = 55};
const Image<std::uint8_t>& everywhere() {
  static const Image<std::uint8_t> mask(picture, 1);
  return mask;
}

Reproduction figure_31(std::uint64_t seed) {
  const auto mean = [](std::uint64_t noise) {
    const FrameSet frames =
        frames_of(PhaseMeasuring{.steps = 3}, published_light, of_variance_2, noise);
    return weighted_sum(frames, mean_weights(3));
  };
  return ten_measurements("3.1", "(3.20)", 2.0026, seed, [&](std::uint64_t noise) {
    return noise_from_means(mean(noise), 3, mean(noise + 1), 3, everywhere()).variance;
  });
}

Reproduction figure_38(std::uint64_t seed) {
  return ten_measurements("3.8", "(3.79)", 1.9983, seed, [&](std::uint64_t noise) {
    const FrameSet frames =
        frames_of(PhaseMeasuring{.steps = 4}, published_light, of_variance_2, noise);
    return noise_from_half_phase(weighted_sum(frames, half_phase_weights()), everywhere()).variance;
  });
}

/// Effect of noise on 3-step PMP at each reflectivity, for alpha_p = 255, sigma_w^2 = 2.
struct NoiseOfPmp {
  PlotLine reflectivity{"measured"}, phase{"measured"};
};

NoiseOfPmp noise_of_pmp(std::uint64_t seed) {
  const PhaseDecoder decode(PhaseMethod::equation, {3});
  const Image<double> y = smooth_coordinate(picture);
  NoiseOfPmp noise;
  for (int i = 0; i <= 20; ++i) {
    const double alpha = i / 20.0;
    const FrameSet frames = frames_of(PhaseMeasuring{.steps = 3}, {.alpha_p = 255, .beta_p = 0},
                                      {.alpha = alpha, .beta = 0, .noise_variance = 2},
                                      seed * 1000 + static_cast<std::uint64_t>(i));
    PhaseMaps maps = decode(frames, 0, 3);
    std::transform(maps.wrapped_phase.begin(), maps.wrapped_phase.end(), y.begin(),
                   maps.wrapped_phase.begin(), [](double phi, double coordinate) {
                     return std::remainder(phi - 2 * pi * coordinate, 2 * pi);
                   });
    noise.reflectivity.add(alpha, variance_of(maps.modulation) * 4 / (255.0 * 255.0));  // (3.6)
    noise.phase.add(alpha, variance_of(maps.wrapped_phase));
  }
  return noise;
}

/// Measured values, and the values that an equation predicts at the same reflectivities.
template <class Predict>
Reproduction compared(const char* figure, const char* quantity, const char* unit,
                      const PlotLine& measured, const char* equation, const Predict& predict) {
  Reproduction result;
  PlotLine predicted{equation};
  for (std::size_t i = 0; i < measured.x.size(); ++i) {
    const double alpha = measured.x[i];
    predicted.add(alpha, predict(alpha));
    if (!std::isfinite(predicted.y.back())) continue;
    result.add(fmt::format("variance of the {}", quantity), {{"alpha", alpha}}, predicted.y.back(),
               measured.y[i]);
  }
  result.notes.emplace_back("Published: the equation; recomputed: simulated pixels.");
  result.draw(fmt::format("figure-{}", figure),
              fmt::format("Variance of the {}, N = 3, sigma_w^2 = 2", quantity), "reflectivity",
              unit, PlotScale::logarithmic, {measured, predicted});
  return result;
}

Reproduction figure_32(std::uint64_t seed) {
  return compared("3.2", "reflectivity", "variance", noise_of_pmp(seed).reflectivity, "Eq. (3.27)",
                  [](double) { return reflectivity_variance(3, 255, 2); });
}

Reproduction figure_33(std::uint64_t seed) {
  return compared("3.3", "phase, rad^2", "rad^2", noise_of_pmp(seed).phase, "Eq. (3.38)",
                  [](double alpha) { return phase_variance(3, alpha, 255, 2); });
}

/// Normalised variance of the reference over c_1, averaged over the field; `variance`: of (c_1, y).
template <class Variance>
Reproduction best_share(const char* figure, const char* title, const Variance& variance) {
  PlotLine line{"mean over the field"};
  for (int i = 5; i <= 95; ++i) {
    const double c1 = i / 100.0;
    constexpr int places = 100;
    double sum = 0;
    for (int place = 0; place < places; ++place) sum += variance(c1, (place + 0.5) / places);
    line.add(c1, sum / places);
  }
  const auto least =
      static_cast<std::size_t>(std::min_element(line.y.begin(), line.y.end()) - line.y.begin());
  Reproduction result;
  result.add("c_1 of the least variance", {{"alpha_p", 200.0}}, 0.5, line.x[least]);
  result.add("least variance over sigma_w^2", {{"alpha_p", 200.0}}, {}, line.y[least]);
  result.notes.emplace_back("alpha = 0.5, beta = -7, beta_p = 55.");
  result.draw(fmt::format("figure-{}", figure), title, "c_1", "variance of R over sigma_w^2",
              PlotScale::logarithmic, {line});
  return result;
}

Reproduction figure_35(std::uint64_t) {
  return best_share("3.5", "Noise of the reference signal, N = 3, Eq. (3.67)",
                    [](double c1, double y) {
                      return dc_reference_variance(0.5, published_light, -7, c1, 2 * y - 1);
                    });
}

Reproduction figure_37(std::uint64_t) {
  return best_share("3.7", "Noise of the reference signal, N = 4, Eq. (3.76)",
                    [](double c1, double y) {
                      return half_phase_reference_variance(0.5, 200, c1, std::cos(pi * y));
                    });
}

/// Modulations B_1^c and B_2^c of 5-pattern PCMP at sigma_w^2 = 1.6.
struct Modulations {
  Image<double> first, second;
};

Modulations modulations(double c1, std::uint64_t seed) {
  // At so small a share the high frequency needs more periods to be worthwhile, Eq. (3.64).
  const Strategy strategy =
      PhaseChannelMultiplexing{.steps = 5, .high = 12, .share = c1, .reference = {}};
  const FrameSet frames =
      frames_of(strategy, published_light, {.alpha = 0.5, .beta = -7, .noise_variance = 1.6}, seed);
  const PhaseDecoder decode(PhaseMethod::equation, {});
  const std::vector<Band>& bands = strategy.layout().bands;
  return {decode(frames, bands[0]).modulation, decode(frames, bands[1]).modulation};
}

Reproduction figure_310(std::uint64_t seed) {
  PlotLine first{"alpha_1"}, second{"alpha_2"}, weighted{"weighted"};
  Reproduction result;
  for (int i = 20; i <= 80; i += 5) {
    const double c1 = i / 100.0, c2 = 1 - c1;
    const auto [B_1, B_2] = modulations(c1, seed * 1000 + static_cast<std::uint64_t>(i));
    Image<double> alpha_1(picture), alpha_2(picture), alpha(picture);
    for (std::size_t p = 0; p < alpha.pixel_count(); ++p) {
      alpha_1.begin()[p] = reflectivity(B_1.begin()[p], 200, c1);
      alpha_2.begin()[p] = reflectivity(B_2.begin()[p], 200, c2);
      alpha.begin()[p] = weighted_reflectivity(alpha_1.begin()[p], alpha_2.begin()[p], c1);
    }
    const auto add = [&](PlotLine& line, const char* quantity, const Image<double>& values,
                         double predicted) {
      line.add(c1, variance_of(values));
      result.add(quantity, {{"c_1", c1}}, predicted, line.y.back());
    };
    add(first, "variance of alpha_1, (3.95)", alpha_1, reflectivity_variance(5, 200, 1.6, c1));
    add(second, "variance of alpha_2, (3.96)", alpha_2, reflectivity_variance(5, 200, 1.6, c2));
    add(weighted, "variance of the weighted alpha, (3.98)", alpha,
        weighted_reflectivity_variance(5, 200, 1.6));
  }
  result.notes.emplace_back("Published: the equation; recomputed: simulated pixels.");
  result.draw("figure-3.10", "Variance of the reflectivity, 5-pattern PCMP", "c_1", "variance",
              PlotScale::logarithmic, {first, second, weighted});
  return result;
}

Reproduction figure_311(std::uint64_t seed) {
  PlotLine line;
  Reproduction result;
  for (int i = 50; i <= 80; i += 5) {
    const double c1 = i / 100.0;
    const auto [B_1, B_2] = modulations(c1, seed * 1000 + static_cast<std::uint64_t>(i));
    line.add(c1, noise_from_modulations(B_1, B_2, 5, c1, everywhere()).variance);
    result.add("sigma_w^2 by (3.99)", {{"c_1", c1}}, 1.6, line.y.back());
  }
  result.notes.emplace_back("Published: the variance of the simulated noise.");
  result.draw("figure-3.11", "Noise variance from one 5-pattern PCMP scan", "c_1", "sigma_w^2",
              PlotScale::linear, {line});
  return result;
}

}  // namespace

std::vector<Reproducible> noise_figure_reproducibles() {
  return {{"figure", "3.1", "noise measured from the means of two scans", figure_31},
          {"figure", "3.2", "noise of the reflectivity", figure_32},
          {"figure", "3.3", "noise of the phase", figure_33},
          {"figure", "3.5", "noise of the reference signal in the DC channel", figure_35},
          {"figure", "3.7", "noise of the reference signal in the half phase channel", figure_37},
          {"figure", "3.8", "noise measured from the half phase channel", figure_38},
          {"figure", "3.10", "noise of the reflectivity of 5-pattern PCMP", figure_310},
          {"figure", "3.11", "noise measured from one 5-pattern PCMP scan", figure_311}};
}

}  // namespace slipstream
