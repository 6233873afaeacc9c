#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/source_flags.h"
#include "live/cyclic_scans.h"
#include "response/exposure_advice.h"

namespace slipstream::app {
namespace {

struct AssistFlags {
  std::string scan;
  SourceFlags source;
  ExposureNeeds needs;
  std::optional<double> noise_variance;
};

/// A scan whose sequence holds the exposures it was taken with.
Scan from_scan(const AssistFlags& flags, Output& output) {
  const ScanChanges changes{.sequence = flags.source.sequence, .scanner = flags.source.scanner};
  Scan scan = load_checkable(flags.scan, changes, false, output);
  scan.sequence.exposures = scan.exposures;
  return scan;
}

/// Opens the source once per exposure; a camera is set to that exposure in ms.
Scan from_source(const AssistFlags& flags, Output& output) {
  throw_if(
      scheme_of(flags.source.source) == "replay",
      "--source: a recording already holds its exposures; give the recording without --source");

  SourceRequest request = request_from(flags.source);

  // Each exposure is four times the one before, relative for the virtual camera, in ms for others.
  const std::vector<double> usual =
      request.world ? std::vector<double>{0.25, 1, 4} : std::vector<double>{2, 8, 32};
  const std::vector<double> exposures = request.sequence.exposures.value_or(usual);

  Scan taken;
  std::vector<FrameSet> each;
  for (const double exposure : exposures) {
    // One exposure at a time: the camera is opened again with its exposure time in s.
    request.sequence.exposures = {exposure};
    request.camera.exposure = exposure / 1e3;
    const NamedSource opened = open(request, output);

    each.push_back(take_window(*opened.frames, opened.sequence, request.source));
    taken.sequence = opened.sequence;
    taken.scanner = opened.scanner;
  }

  taken.frames = joined(std::move(each));
  taken.sequence.exposures = exposures;
  return taken;
}

void tell(const char* name, const std::vector<ExposureChoice>& choices, Output& output) {
  output.document[name] = as_json(choices, [](const ExposureChoice& choice) {
    return described("exposures", choice.exposures, "measured", choice.measured, "saturated",
                     choice.saturated, "too_dark", choice.too_dark, "coordinate_sigma",
                     choice.sigma);
  });

  for (const ExposureChoice& choice : choices) {
    output.say("{:<9}{:<22}{:8.1f} %{:10.1f} %{:9.1f} %{:10.2g}", name,
               fmt::format("{:.3g}", fmt::join(choice.exposures, ",")), 100 * choice.measured,
               100 * choice.saturated, 100 * choice.too_dark, choice.sigma);
  }
}

void tell(const ExposureAdvice& advice, const PatternLight& light, Output& output) {
  output.say("{:.1f} % of the pixels are lit; of these", 100 * advice.lit);

  // Columns: name, exposures, shares of the lit pixels, standard deviation of the coordinate.
  output.say("{:<9}{:<22}{:>10}{:>12}{:>11}{:>10}", "", "exposures", "measured", "saturated",
             "too dark", "sigma");
  tell("taken", advice.taken, output);
  tell("proposed", advice.proposed, output);

  const ExposureChoice& best = advice.proposed[advice.best];
  output.say("--exposures {:.3g}", fmt::join(best.exposures, ","));

  // Gain of each further exposure over one less.
  for (std::size_t i = 1; i < advice.proposed.size(); ++i) {
    const double gain = advice.proposed[i].measured - advice.proposed[i - 1].measured;
    output.say("  a {} exposure measures {:.1f} % more of the lit pixels: {}",
               i == 1 ? "second" : "third", 100 * gain,
               i <= advice.best ? "worth it" : "not worth it");
  }

  // The shortest exposure should shrink by more than a tenth.
  if (advice.light < 0.9) {
    output.say(
        "  the shortest exposure taken is still too long on its own; adding --alpha-p {:.0f} has "
        "the same effect",
        advice.light * light.alpha_p);
  }

  // Over 0.5 % of the lit pixels are clipped even in the shortest exposure: their level is unknown.
  if (advice.unknown > 0.005) {
    output.say(
        "  {:.1f} % of the lit pixels are saturated in every exposure taken: add a shorter one",
        100 * advice.unknown);
  }
}

void assist(const AssistFlags& flags, Output& output) {
  const Scan taken = flags.scan.empty() ? from_source(flags, output) : from_scan(flags, output);

  // Noise variance: the flag's, else the scanner file's, else the usual one.
  ExposureNeeds needs = flags.needs;
  if (taken.scanner) {
    needs.noise_variance = taken.scanner->photometry.noise_variance.value_or(needs.noise_variance);
  }
  needs.noise_variance = flags.noise_variance.value_or(needs.noise_variance);

  const ExposureAdvice advice = exposure_advice(taken.frames, taken.sequence, needs);
  output.document = described("lit", advice.lit, "unknown", advice.unknown, "exposures",
                              advice.proposed[advice.best].exposures, "light", advice.light);

  tell(advice, taken.sequence.light, output);
}

}  // namespace

void add_assist(const Commands& program) {
  const auto [command, flags] = program.add(
      assist, "assist", "recommend exposures: the share of lit pixels that each one measures");

  SourceFlags& source = flags.source;
  CLI::Option* const scan =
      command.add("scan", flags.scan, "a scan with one or several exposures; or use --source");

  command
      .add("--source", source.source,
           fmt::format("{}; takes 2, 8 and 32 ms (virtual camera: 0.25, 1 and 4) unless "
                       "--exposures names others",
                       source_forms()))
      ->excludes(scan);

  command.add_file("--scanner", source.scanner, "scanner file; its noise variance is used");
  command.add(
      "--noise-variance", flags.noise_variance,
      "noise variance sigma_w^2, squared grey levels of 255; default: from the scanner file");
  command.add("--minimum-modulation", flags.needs.least_modulation,
              "minimum modulation of a measured pixel, grey levels of 255");

  add_source_flags(command.app, source, false);
  command.common({"--source", "--exposures", "--scanner", "--gain", "--strategy", "--steps"});
  command.examples({"assist scan", "assist --source virtual --scene contrast",
                    "assist --source aravis: --strategy pmp --steps 4 --exposures 1,4,16"});
}

}  // namespace slipstream::app
