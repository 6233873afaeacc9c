#include "response/exposure_advice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "decode/phase_decoder.h"

namespace slipstream {
namespace {

/// For exposure 1, grey levels of 255.
struct LitPixel {
  double modulation = 0;
  double peak = 0;  ///< of its brightest frame
};

struct LitPixels {
  std::vector<LitPixel> known{};
  std::size_t saturated = 0;  ///< in all exposures
  std::size_t all = 0;        ///< pixels of the camera

  [[nodiscard]] std::size_t count() const { return known.size() + saturated; }
};

/// B of the weakest band.
Image<double> modulation(const FrameViews& frames, const Layout& layout) {
  const PhaseDecoder decode(PhaseMethod::equation, {});
  Image<double> least(frames.size(), std::numeric_limits<double>::infinity());
  for (const Band& band : layout.bands) {
    const Image<double> B = decode(frames, band).modulation;
    std::ranges::transform(least, B, least.begin(),
                           [](double one, double other) { return std::min(one, other); });
  }

  return least;
}

Image<double> brightest_level(const FrameViews& frames) {
  Image<double> brightest(frames.size());
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for_each_pixel_in_order(view.size(), [&](int column, int row) {
        double& level = brightest(column, row);
        level = std::max(level, static_cast<double>(view(column, row)));
      });
    }
  });

  return brightest;
}

/// `shortest`: the exposure at a gain of 1.
LitPixels lit_pixels(const FrameViews& frames, const Layout& layout, double shortest,
                     double noise_variance) {
  constexpr double deviations = 5;

  // The modulation that noise alone does not reach, even in the noisiest band.
  const double noise = std::ranges::max(layout.bands | std::views::transform(component_noise));
  const double least = deviations * std::sqrt(noise * noise_variance);

  const double grey_level = frames.full_scale() / 255;
  const Image<double> B = modulation(frames, layout), peak = brightest_level(frames);

  LitPixels lit{.all = B.pixel_count()};
  for_each_pixel_in_order(B.size(), [&](int column, int row) {
    const double level = peak(column, row);
    if (frames.quantised() && level >= frames.saturation()) {
      ++lit.saturated;
    } else if (B(column, row) / grey_level >= least) {
      const double gain = frames.merged() ? frames.gain()(column, row) : 1;
      const double scale = 1 / (grey_level * gain * shortest);
      lit.known.push_back({B(column, row) * scale, level * scale});
    }
  });
  return lit;
}

/// Grey levels above may be saturated, with noise of 3 standard deviations.
double brightest_unsaturated(const ExposureNeeds& needs) {
  return 255 - 3 * std::sqrt(needs.noise_variance);
}

/// Predicts the effect of exposures on the pixels of one scan.
struct Prediction {
  std::vector<LitPixel> samples{};
  double unknown = 0;  ///< share of the lit pixels saturated in the shortest exposure
  const Layout& layout;
  const ExposureNeeds& needs;
  double brightest = brightest_unsaturated(needs);

  [[nodiscard]] ExposureChoice of(const std::vector<double>& exposures) const {
    std::vector<double> measured;
    std::size_t saturated = 0;

    for (const LitPixel& pixel : samples) {
      const double B = merged_modulation(pixel, exposures);
      if (B == 0) ++saturated;
      if (B >= needs.least_modulation) measured.push_back(B);
    }

    // Pixels saturated in the scan count as saturated: their level is unknown.
    const double share =
        (1 - unknown) / static_cast<double>(std::max<std::size_t>(samples.size(), 1));
    ExposureChoice choice{.exposures = exposures,
                          .measured = share * static_cast<double>(measured.size()),
                          .saturated = unknown + share * static_cast<double>(saturated)};
    choice.too_dark = std::max(0.0, 1 - choice.measured - choice.saturated);

    if (!measured.empty()) {
      choice.sigma =
          std::sqrt(coordinate_variance(layout, quantile(measured, 0.5), needs.noise_variance));
    }

    return choice;
  }

  /// The measured share, with a weight of one per cent for its quality.
  [[nodiscard]] double worth(const std::vector<double>& exposures) const {
    double worth = 0;

    for (const LitPixel& pixel : samples) {
      const double B = merged_modulation(pixel, exposures);
      if (B >= needs.least_modulation) worth += 1 - 0.01 * needs.least_modulation / B;
    }

    return worth;
  }

  /// As in merge_exposures; 0 if every exposure saturates the pixel.
  [[nodiscard]] double merged_modulation(const LitPixel& pixel,
                                         const std::vector<double>& exposures) const {
    double squares = 0;
    for (const double t : exposures) {
      if (pixel.peak * t < brightest) squares += t * t;
    }

    return pixel.modulation * std::sqrt(squares);
  }
};

/// Samples a limited number of pixels, evenly over the image.
Prediction prediction_of(const LitPixels& lit, const Layout& layout, const ExposureNeeds& needs) {
  constexpr std::size_t most = 20000;
  const double unknown = static_cast<double>(lit.saturated) / static_cast<double>(lit.count());

  Prediction prediction{.unknown = unknown, .layout = layout, .needs = needs};
  const std::size_t step = lit.known.size() / most + 1;
  for (std::size_t i = 0; i < lit.known.size(); i += step) {
    prediction.samples.push_back(lit.known[i]);
  }

  return prediction;
}

/// Four per doubling, from unsaturated brightest pixels to measurable darkest ones.
std::vector<double> candidates(const Prediction& prediction, const ExposureNeeds& needs) {
  constexpr double few = 0.001;  // fraction of pixels to ignore
  constexpr std::size_t most = 64;

  std::vector<double> peaks, modulations;
  for (const LitPixel& pixel : prediction.samples) {
    peaks.push_back(pixel.peak);
    modulations.push_back(pixel.modulation);
  }

  // From 5 % below saturation of the brightest to 20 % above the limit of the darkest.
  const double first = 0.95 * prediction.brightest / quantile(peaks, 1 - few);
  const double last = 1.2 * needs.least_modulation / quantile(modulations, few);
  const double longest = std::min(last, needs.longest);
  std::vector<double> exposures{std::clamp(first, needs.shortest, needs.longest)};

  while (exposures.back() < longest && exposures.size() < most) {
    exposures.push_back(std::min(exposures.back() * std::pow(2.0, 0.25), needs.longest));
  }

  return exposures;
}

/// Optimises each exposure in turn, given the others, until none changes.
std::vector<double> best_of(std::size_t count, const Prediction& prediction,
                            const std::vector<double>& candidates, std::vector<double> exposures) {
  exposures.resize(count, candidates.front());
  for (bool changed = true; std::exchange(changed, false);) {
    for (std::size_t i = count; i-- > 0;) {
      for (const double candidate : candidates) {
        std::vector<double> other = exposures;
        other[i] = candidate;

        // Ignores gains of rounding errors, which would never end.
        if (prediction.worth(other) <= prediction.worth(exposures) * (1 + 1e-9)) continue;

        exposures = other;
        changed = true;
      }
    }
  }

  return exposures;
}

/// To two digits: cameras need no more.
double rounded(double exposure) {
  const double digit = std::pow(10, std::floor(std::log10(exposure)) - 1);
  return std::round(exposure / digit) * digit;
}

void propose(const Prediction& prediction, const ExposureNeeds& needs, ExposureAdvice& advice) {
  // Share of the lit pixels that makes one more exposure worth its time.
  constexpr double worth_one_more = 0.02;
  const std::vector<double> from = candidates(prediction, needs);

  std::vector<double> exposures;
  for (const std::size_t count : {1U, 2U, 3U}) {
    exposures = best_of(count, prediction, from, exposures);

    std::vector<double> choice = exposures;
    std::ranges::sort(choice);
    std::ranges::transform(choice, choice.begin(), [&](double exposure) {
      return std::clamp(rounded(exposure), needs.shortest, needs.longest);
    });
    advice.proposed.push_back(prediction.of(choice));
  }

  while (advice.best + 1 < advice.proposed.size() &&
         advice.proposed[advice.best + 1].measured >=
             advice.proposed[advice.best].measured + worth_one_more) {
    ++advice.best;
  }
}

}  // namespace

ExposureAdvice exposure_advice(const FrameViews& given, const Sequence& sequence,
                               const ExposureNeeds& needs) {
  require_in_range(needs.least_modulation > 0 && needs.least_modulation <= 127, "least modulation",
                   needs.least_modulation, "above 0, up to 127 grey levels");
  // With more noise, every level may be saturated.
  require_in_range(needs.noise_variance >= 0 && brightest_unsaturated(needs) > 0, "noise variance",
                   needs.noise_variance, "0 or more, below 7225 grey levels^2");

  const std::vector<double>& exposures = sequence.exposures;
  if (!given.merged() && exposures.size() > 1) {
    return exposure_advice(merged_exposures(given, exposures), sequence, needs);
  }

  const Layout& layout = sequence.strategy.layout();
  throw_if(given.count() != layout.frames, "{} frames given; the strategy has {}", given.count(),
           layout.frames);

  const double shortest = *std::ranges::min_element(exposures);
  const LitPixels lit = lit_pixels(given, layout, shortest, needs.noise_variance);

  if (lit.known.empty()) {
    throw Error(lit.saturated > 0
                    ? "every lit pixel is saturated; use a shorter exposure"
                    : "no pixel shows the patterns; use a longer exposure, or inspect "
                      "the frames with `view()`");
  }

  const Prediction prediction = prediction_of(lit, layout, needs);
  ExposureAdvice advice{.lit = static_cast<double>(lit.count()) / static_cast<double>(lit.all),
                        .unknown = prediction.unknown};

  // The exposures of the frames themselves, alone and merged, then better ones.
  for (const double t : exposures) advice.taken.push_back(prediction.of({t}));
  if (exposures.size() > 1) advice.taken.push_back(prediction.of(exposures));
  propose(prediction, needs, advice);
  advice.light = std::min(1.0, advice.proposed.front().exposures.front() / shortest);

  return advice;
}

}  // namespace slipstream
