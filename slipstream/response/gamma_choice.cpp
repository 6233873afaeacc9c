#include "slipstream/response/gamma_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <variant>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/base/statistics.h"

namespace slipstream {
namespace {

using Complex = std::complex<double>;

using Samples = std::vector<HarmonicSample>;

/// The gamma that the medians of the pixels agree on, within 1 %.
double agreed_gamma(const Samples& samples, int steps) {
  const ConstraintCurve curve = constraint_curve(samples, PowerLaw{1}, steps);
  double best_gamma = 1, best = std::numeric_limits<double>::infinity();
  for (double gamma = least_gamma; gamma <= largest_gamma; gamma *= 1.02) {
    const double left = distance(curve, PowerLaw{gamma});
    if (left < best) {
      best = left;
      best_gamma = gamma;
    }
  }
  return best_gamma;
}

struct Fit {
  double gamma = 1;
  double standard_error = 0;
  double offset = 0;  ///< light that no gamma explains, grey levels
};

enum class Offset { none, free };

/// Least squares with Tukey's weights, from a gamma near the solution. With a free offset the mean
/// of every pixel may hold the same light besides the pattern's (N = 3).
Fit fitted(const Samples& samples, int steps, double gamma, Offset offset) {
  Fit fit{.gamma = gamma};
  for (int round = 0; round < 60; ++round) {
    const double h = 1e-3 * fit.gamma;
    const auto model = predicted(samples, PowerLaw{fit.gamma}, steps);
    const auto below = predicted(samples, PowerLaw{fit.gamma - h}, steps);
    const auto above = predicted(samples, PowerLaw{fit.gamma + h}, steps);
    // In grey levels: residual r, its slopes with gamma, J, and with the offset, 1.
    const auto residual = [&](std::size_t i) {
      return (samples[i].constraint.second - model[i].second) * samples[i].modulation -
             (offset == Offset::free ? fit.offset : 0);
    };
    const auto slope = [&](std::size_t i) {
      return (above[i].second - below[i].second) * (samples[i].modulation / (2 * h));
    };
    std::vector<double> sizes;
    sizes.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) sizes.push_back(std::abs(residual(i)));
    const double scale = std::max(deviation_from_median(median(sizes)), 1e-10);

    double JJ = 0, J1 = 0, weights = 0, Jr = 0, r1 = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = tukey_weight(sizes[i] / scale);
      const Complex J = slope(i), r = residual(i);
      JJ += weight * std::norm(J);
      J1 += weight * J.real();
      weights += weight;
      Jr += weight * (std::conj(J) * r).real();
      r1 += weight * r.real();
    }
    const double free = offset == Offset::free ? 1 : 0;
    const double determinant = JJ * weights - free * J1 * J1;
    const double step = (Jr * weights - free * J1 * r1) / determinant;
    fit.offset += free * (JJ * r1 - J1 * Jr) / determinant;

    double scatter = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double weight = tukey_weight(sizes[i] / scale);
      const Complex along = std::conj(slope(i) * weights - free * J1) * residual(i);
      scatter += weight * weight * along.real() * along.real();
    }
    fit.standard_error = std::sqrt(scatter) / determinant;
    const double limited = std::clamp(step, -0.1 * fit.gamma, 0.1 * fit.gamma);
    fit.gamma = std::clamp(fit.gamma + limited, least_gamma / 2, 2 * largest_gamma);
    if (std::abs(step) < 1e-9) break;
  }
  return fit;
}

/// What noise has put just outside, at the end of the range.
double in_range_but_for_noise(double gamma) {
  const double inside = std::clamp(gamma, least_gamma, largest_gamma);
  return std::abs(inside - gamma) <= 0.01 * gamma ? inside : gamma;
}

/// Whether the power law leaves no more than noise, or than a small part of what it explains, of
/// what the pixels say. The fewer the steps, the better other responses pass for one: four see odd
/// harmonics, which bend their phase, in the mean alone, and three have nothing else.
bool follows_power_law(const Samples& samples, double gamma, int steps) {
  if (!(gamma >= least_gamma && gamma <= largest_gamma)) return false;
  const Response law = PowerLaw{gamma}, linear = PowerLaw{1};
  const ConstraintCurve curve = constraint_curve(samples, law, steps);
  const double of_mean = misfit_of_mean(curve, law), drowned = 0.1 * curve.noise;
  if (steps == 3) return of_mean <= std::max(0.002, drowned);
  const double share = steps == 4 ? 0.01 : 0.05;
  if (misfit(curve, law) > std::max(harmless_misfit(curve), share * misfit(curve, linear))) {
    return false;
  }
  return steps > 4 || of_mean <= std::max({0.001, drowned, 0.2 * misfit_of_mean(curve, linear)});
}

/// Whether light that is not the pattern's, if there is any, leaves gamma as it was found.
bool survives_ambient_light(const Samples& samples, const Fit& fit, double tolerance) {
  const Fit with_offset = fitted(samples, 3, fit.gamma, Offset::free);
  return std::abs(with_offset.gamma - fit.gamma) <= tolerance &&
         3 * with_offset.standard_error <= tolerance;
}

GammaChoice corrected_for(const MeasuredResponse& response, std::string_view source) {
  GammaChoice choice{.response = response, .source = std::string(source)};
  if (const auto* law = std::get_if<PowerLaw>(&response.response)) {
    choice.gamma = law->gamma;
    choice.sentence = fmt::format("phase corrected for gamma {:.5g} ({})", law->gamma, source);
  } else {
    choice.sentence = fmt::format("phase corrected for the measured response ({})", source);
  }
  return choice;
}

/// Of the scan's sinusoids the one that is surest of its gamma; where all refuse, the first, and
/// one that follows no power law before all, because the others may have too few steps to see it.
BlindGamma surest_gamma(const Layout& layout, const FrameViews& frames) {
  std::optional<BlindGamma> surest;
  for (const Band& band : layout.bands) {
    const auto run = step_run(band);
    if (!run) continue;
    const BlindGamma found = find_gamma(frames, run->first, run->steps);
    if (found.refusal == BlindRefusal::no_power_law) return found;
    const bool better =
        !surest || (found.accepted() &&
                    (!surest->accepted() || found.standard_error < surest->standard_error));
    if (better) surest = found;
  }
  return surest.value_or(BlindGamma{.refusal = BlindRefusal::no_power_law});
}

GammaChoice blind_choice(const Layout& layout, const FrameViews& frames) {
  const BlindGamma found = surest_gamma(layout, frames);
  const std::string value = fmt::format("gamma {:.5g}, standard error {:.2g}, from {} pixels",
                                        found.gamma, found.standard_error, found.pixels);
  GammaChoice choice{.source = "blind", .gamma = found.gamma, .blind = found};
  if (found.accepted()) {
    MeasuredResponse& measured = choice.response.emplace();
    measured.response = PowerLaw{found.gamma};
    measured.gamma = found.gamma;
    measured.standard_error = found.standard_error;
    choice.sentence = fmt::format("phase corrected blind: {}", value);
  } else {
    choice.sentence =
        fmt::format("phase left alone: {} ({} would fit best)", reason_of(found.refusal), value);
  }
  return choice;
}

}  // namespace

std::string_view reason_of(BlindRefusal refusal) {
  static constexpr std::array<std::string_view, 5> reasons{
      "gamma found", "too few pixels are lit and not saturated",
      "ambient light, which three steps cannot tell from gamma", "no distortion to see",
      "the response follows no gamma in range"};
  return reasons[static_cast<std::size_t>(refusal)];
}

BlindGamma find_gamma(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit,
                      int steps) {
  constexpr std::size_t fewest_pixels = 100;
  constexpr double ambient_tolerance = 0.03, negligible = 1e-3;
  const Samples samples = harmonic_samples(pixels, lit, steps);
  BlindGamma found{.pixels = samples.size()};
  if (samples.size() < fewest_pixels) {
    found.refusal = BlindRefusal::too_few_pixels;
    return found;
  }
  const Fit fit = fitted(samples, steps, agreed_gamma(samples, steps), Offset::none);
  found.gamma = in_range_but_for_noise(fit.gamma);
  found.standard_error = fit.standard_error;
  if (steps == 3 && !survives_ambient_light(samples, fit, ambient_tolerance * fit.gamma)) {
    found.refusal = BlindRefusal::ambient_light;
  } else if (!follows_power_law(samples, found.gamma, steps)) {
    found.refusal = BlindRefusal::no_power_law;
  } else if (std::abs(fit.gamma - 1) <= std::max(3 * fit.standard_error, negligible)) {
    found.refusal = BlindRefusal::no_distortion;
  }
  return found;
}

BlindGamma find_gamma(const FrameViews& frames, int first, int steps) {
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, first, steps);
  return find_gamma(pixels, well_lit(pixels, frames), steps);
}

GammaChoice choose_gamma(const std::string& how,
                         const std::optional<MeasuredResponse>& of_scanner) {
  if (how == "blind") {
    throw Error(
        "--gamma blind needs a scan of a thing at rest; find the number with slipstream "
        "reconstruct --gamma blind and give that");
  }
  if (how == "scanner" && of_scanner) return corrected_for(*of_scanner, "scanner file");
  if (how == "scanner" || how == "none") return {};
  const auto gamma = number_in<double>(how);
  if (!gamma) {
    throw Error(
        fmt::format("--gamma {} is not known; it is scanner, blind, none or a number", how));
  }
  require_gamma(*gamma, "--gamma");
  return corrected_for({PowerLaw{*gamma}, *gamma, 0}, "given");
}

GammaChoice choose_gamma(const std::string& how, const std::optional<MeasuredResponse>& of_scanner,
                         const Layout& layout, const FrameViews& frames) {
  return how == "blind" ? blind_choice(layout, frames) : choose_gamma(how, of_scanner);
}

GammaChoice choose_response(Scan& scan, const std::string& how) {
  for (Scan& further : scan.further_cameras) choose_response(further, how);
  std::optional<MeasuredResponse> known;
  if (scan.scanner) known = scan.scanner->photometry.response;
  GammaChoice choice = choose_gamma(how, known, scan.sequence.strategy.layout(), scan.frames);
  if (scan.scanner) scan.scanner->photometry.response = choice.response;
  return choice;
}

}  // namespace slipstream
