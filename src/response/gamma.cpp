#include "slipstream/gamma.h"

#include <array>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "response/gamma_calibration.h"

namespace slipstream {
namespace {

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

/// Gamma from the sinusoid with the smallest standard error. If all are refused, the first; one
/// that follows no power law takes precedence: others may have too few steps to see that.
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
  if (step_runs(layout).empty()) {
    return {.source = "blind",
            .sentence = "phase not corrected: `gamma blind` requires a run of equal phase steps"};
  }

  const BlindGamma found = surest_gamma(layout, frames);
  const std::string value = fmt::format("gamma {:.5g}, standard error {:.2g}, from {} pixels",
                                        found.gamma, found.standard_error, found.pixels);
  GammaChoice choice{.source = "blind", .gamma = found.gamma, .blind = found};

  if (found.accepted()) {
    choice.response = {PowerLaw{found.gamma}, found.gamma, found.standard_error};
    choice.sentence = fmt::format("phase corrected blind: {}", value);
  } else {
    choice.sentence =
        fmt::format("phase not corrected: {} (best fit: {})", reason_of(found.refusal), value);
  }

  return choice;
}

}  // namespace

std::string_view reason_of(BlindRefusal refusal) {
  static constexpr std::array<std::string_view, 5> reasons{
      "gamma found", "too few pixels are lit and unsaturated",
      "three steps cannot distinguish gamma from ambient light", "no measurable distortion",
      "the response matches no gamma in range"};
  return reasons[static_cast<std::size_t>(refusal)];
}

GammaChoice choose_gamma(const std::string& how,
                         const std::optional<MeasuredResponse>& of_scanner) {
  throw_if(how == "blind",
           "`gamma blind` requires a scan of a static scene; find gamma with `reconstruct()` "
           "`gamma blind` and pass that number");

  if (how == "scanner" && of_scanner) return corrected_for(*of_scanner, "scanner file");
  if (how == "scanner" || how == "none") return {};

  const auto gamma = number_in<double>(how);
  throw_if(!gamma, "`gamma` '{}' is unknown; expected scanner, blind, none or a number", how);
  require_gamma(*gamma, "`gamma`");
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
