#include "app/source_flags.h"
#include "slipstream/live/cyclic_scans.h"
#include "slipstream/response/exposure_advice.h"

namespace slipstream::app {
namespace {

struct AssistFlags {
  std::string scan;
  SourceFlags source;
  ExposureNeeds needs;
  std::optional<double> noise_variance;
};

/// A scan whose sequence has the exposures that were taken.
Scan from_scan(const AssistFlags& flags, Output& output) {
  ScanFlags input;
  input.sequence = flags.source.sequence;
  input.scanner = flags.source.scanner;
  Scan scan = load_checkable(flags.scan, input, false, output);
  scan.sequence.exposures = scan.exposures;
  return scan;
}

/// Opens the source once for each exposure, a camera set to it in ms.
Scan from_source(const AssistFlags& flags, Output& output) {
  throw_if(scheme_of(flags.source.source) == "replay",
           "--source: frames that were recorded have their exposures; give the recording alone");
  SourceRequest request = request_from(flags.source);
  const std::vector<double> usual =
      request.world ? std::vector<double>{0.25, 1, 4} : std::vector<double>{2, 8, 32};
  const std::vector<double> exposures = request.sequence.exposures.value_or(usual);
  Scan taken;
  std::vector<FrameSet> each;
  for (const double exposure : exposures) {
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
  output.say("{:.1f} % of the pixels are lit; of them", 100 * advice.lit);
  output.say("{:<9}{:<22}{:>10}{:>12}{:>11}{:>10}", "", "exposures", "measured", "saturated",
             "too dark", "sigma");
  tell("taken", advice.taken, output);
  tell("proposed", advice.proposed, output);
  const ExposureChoice& best = advice.proposed[advice.best];
  output.say("--exposures {:.3g}", fmt::join(best.exposures, ","));
  for (std::size_t i = 1; i < advice.proposed.size(); ++i) {
    const double gain = advice.proposed[i].measured - advice.proposed[i - 1].measured;
    output.say("  a {} exposure measures {:.1f} % more of the lit pixels: {}",
               i == 1 ? "second" : "third", 100 * gain,
               i <= advice.best ? "worth it" : "not worth it");
  }
  if (advice.light < 0.9) {
    output.say(
        "  the shortest taken is too long for one alone; --alpha-p {:.0f} with it does the "
        "same",
        advice.light * light.alpha_p);
  }
  if (advice.unknown > 0.005) {
    output.say(
        "  {:.1f} % of the lit pixels are saturated in all exposures taken: take a shorter "
        "one to see what they need",
        100 * advice.unknown);
  }
}

void assist(const AssistFlags& flags, Output& output) {
  const Scan taken = flags.scan.empty() ? from_source(flags, output) : from_scan(flags, output);
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
      assist, "assist", "which exposures measure which share of what the patterns light");
  SourceFlags& source = flags.source;
  CLI::Option* const scan =
      command.add("scan", flags.scan, "a scan, of one or several exposures; or --source");
  command
      .add("--source", source.source,
           fmt::format("{}; set to the exposures itself: to 2, 8 and 32 ms, the virtual one to "
                       "0.25, 1 and 4, where --exposures says no others",
                       source_forms()))
      ->excludes(scan);
  command.add_file("--scanner", source.scanner, "scanner file, for its noise");
  command.add("--noise-variance", flags.noise_variance,
              "sigma_w^2, grey levels^2 of 255, where not that of the scanner file");
  command.add("--min-modulation", flags.needs.least_modulation,
              "of a pixel that counts as measured, grey levels of 255");
  add_source_flags(command.app, source, false);
  command.examples({"assist scan", "assist --source virtual --scene contrast",
                    "assist --source aravis: --strategy pmp --steps 4 --exposures 1,4,16"});
}

}  // namespace slipstream::app
