#include "app/gamma_choice.h"

#include <charconv>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/gamma/blind.h"
#include "slipstream/gamma/correction.h"
#include "slipstream/io/response_file.h"

namespace slipstream::app {
namespace {

GammaChoice with_response(const Response& response, const std::vector<int>& steps,
                          std::string_view source) {
  GammaChoice choice;
  choice.corrections = phase_corrections(response, steps);
  choice.source = source;
  if (const auto* law = std::get_if<PowerLaw>(&response)) {
    choice.gamma = law->gamma;
    choice.sentence = fmt::format("phase corrected for gamma {:.5g} ({})", law->gamma, source);
  } else {
    choice.sentence = fmt::format("phase corrected for the measured response ({})", source);
  }
  return choice;
}

/// Of the scan's sinusoids the one that is surest of its gamma; where all refuse, the first.
BlindGamma surest_gamma(const std::vector<int>& steps, const FrameSet& frames) {
  std::optional<BlindGamma> surest;
  int first = 0;
  for (const int N : steps) {
    const BlindGamma found = find_gamma(frames, first, N);
    first += N;
    const bool better =
        !surest || (found.accepted() &&
                    (!surest->accepted() || found.standard_error < surest->standard_error));
    if (better) surest = found;
  }
  return surest.value_or(BlindGamma{.refusal = BlindRefusal::no_power_law});
}

GammaChoice blind_choice(const std::vector<int>& steps, const FrameSet& frames) {
  const BlindGamma found = surest_gamma(steps, frames);
  const std::string value = fmt::format("gamma {:.5g}, standard error {:.2g}, from {} pixels",
                                        found.gamma, found.standard_error, found.pixels);
  GammaChoice choice;
  if (found.accepted()) {
    choice = with_response(PowerLaw{found.gamma}, steps, "blind");
    choice.sentence = fmt::format("phase corrected blind: {}", value);
  } else {
    choice.source = "blind";
    choice.gamma = found.gamma;
    choice.sentence =
        fmt::format("phase left alone: {} ({} would fit best)", reason_of(found.refusal), value);
  }
  choice.blind = found;
  return choice;
}

}  // namespace

nlohmann::json json_of(const GammaChoice& choice) {
  nlohmann::json document{{"source", choice.source}};
  if (choice.gamma) document["gamma"] = *choice.gamma;
  if (choice.blind) {
    document["standard_error"] = choice.blind->standard_error;
    document["pixels"] = choice.blind->pixels;
    if (!choice.blind->accepted()) document["refused"] = reason_of(choice.blind->refusal);
  }
  return document;
}

GammaChoice choose_gamma(const std::string& flag, const std::optional<Response>& of_scanner,
                         const std::vector<int>& steps) {
  if (flag == "blind") {
    throw Error(
        "--gamma blind needs a scan of a thing at rest; find the number with slipstream "
        "reconstruct --gamma blind and give that");
  }
  if (flag == "scanner" && of_scanner) return with_response(*of_scanner, steps, "scanner file");
  if (flag == "scanner" || flag == "none") return {};
  double gamma = 0;
  const auto [rest, failure] = std::from_chars(flag.data(), flag.data() + flag.size(), gamma);
  if (failure != std::errc() || rest != flag.data() + flag.size()) {
    throw Error(
        fmt::format("--gamma {} is not known; it is scanner, blind, none or a number", flag));
  }
  require_gamma(gamma, "--gamma");
  return with_response(PowerLaw{gamma}, steps, "given");
}

GammaChoice choose_gamma(const std::string& flag, const ScanDescription& scan,
                         const FrameSet& frames) {
  const std::vector<int> steps = step_counts(scan.strategy);
  if (flag == "blind") return blind_choice(steps, frames);
  const bool in_file = flag == "scanner" && scan.scanner;
  return choose_gamma(flag, in_file ? read_response(*scan.scanner) : std::nullopt, steps);
}

}  // namespace slipstream::app
