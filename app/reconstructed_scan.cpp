#include "app/reconstructed_scan.h"

#include "app/manifest.h"

namespace slipstream::app {
namespace {

nlohmann::json json_of(const GammaChoice& choice) {
  nlohmann::json document = described("source", choice.source, "gamma", choice.gamma);
  if (choice.blind) {
    describe(document, "standard_error", choice.blind->standard_error, "pixels",
             choice.blind->pixels);
    if (!choice.blind->accepted()) document["refused"] = reason_of(choice.blind->refusal);
  }
  return document;
}

struct ScanTime {
  const char *name, *words;
  double seconds;
};

std::array<ScanTime, 6> times_of(const ReconstructedScan& scan) {
  return {{{"read", "ms to read", scan.read},
           {"gamma", "for gamma", scan.sound.choosing},
           {"check", "to check", scan.sound.checking},
           {"tables", "for tables", scan.tables},
           {"reconstruct", "to reconstruct", scan.computed},
           {"write", "to write", scan.written}}};
}

}  // namespace

nlohmann::json document_of(const ReconstructedScan& scan) {
  nlohmann::json seconds;
  for (const ScanTime& time : times_of(scan)) seconds[time.name] = time.seconds;
  std::optional<nlohmann::json> epipolar;
  if (scan.epipolar) {
    epipolar = described("median_px", scan.epipolar->median, "median_length_px",
                         scan.epipolar->median_length, "median_sigma_px",
                         scan.epipolar->median_sigma, "doubted", scan.epipolar->doubted);
  }
  nlohmann::json told =
      described("scan", scan.name.path, "window", scan.name.window, "points",
                scan.wanted == Wanted::maps ? 0 : scan.counts[0], "pixels",
                scan.cloud.validity.pixel_count(), "counts", scan.counts, "backend", scan.backend,
                "least_modulation", scan.least_modulation, "gamma", json_of(scan.sound.gamma),
                "baseline_mm", scan.sound.setup.scanner.translation.norm(), "median_depth_mm",
                scan.sound.checked.median_depth, "files", scan.files.named(), "median_sigma_z_mm",
                scan.median_sigma, "rms_mm", scan.rms, "predicted_mm", scan.predicted, "epipolar",
                epipolar, "warnings", scan.warnings, "findings", scan.sound.checked.findings,
                "repairs", scan.sound.checked.repairs, "seconds", seconds);
  // Only --anyway reconstructs a refused scan.
  if (any_wrong(scan.sound.checked.findings)) told["doubted"] = true;
  return told;
}

std::string line_of(const ReconstructedScan& scan) {
  nlohmann::json entry = scan.entry;
  double seconds = 0;
  for (const ScanTime& time : times_of(scan)) seconds += time.seconds;
  entry["seconds"] = seconds;
  if (!scan.failure.empty()) entry["error"] = scan.failure;
  if (scan.failure.empty()) entry["counts"] = as_json(scan.counts);
  return line_of(entry);
}

void tell(const ReconstructedScan& scan, Output& output) {
  output.say("{}: {} {} of {} pixels, backend {}", text_of(scan.name), scan.counts[0],
             scan.wanted == Wanted::maps ? "measured, no points," : "points",
             scan.cloud.validity.pixel_count(), scan.backend);
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (scan.counts[i] == 0) continue;
    output.say("  rejected, {}: {}", name_of(static_cast<Validity>(i)), scan.counts[i]);
  }
  if (scan.counts[static_cast<std::size_t>(Validity::out_of_range)] > 0) {
    const auto [nearest, farthest] = depth_range(scan.sound.setup);
    output.say("  depths kept: {:.0f} to {:.0f} mm; change with --nearest, --farthest or --raw",
               nearest, farthest);
  }
  if (const double depth = scan.sound.checked.median_depth; depth > 0) {
    output.say("  baseline {:.4g} mm, median depth {:.4g} mm",
               scan.sound.setup.scanner.translation.norm(), depth);
  }
  if (scan.rms) {
    output.say(
        "  RMS error against truth: {:.4g} mm{}", *scan.rms,
        scan.predicted ? fmt::format("; predicted from noise: {:.4g} mm", *scan.predicted) : "");
  }
  if (scan.epipolar) {
    output.say(
        "  distance from epipolar lines: median {:+.3f}, absolute {:.3f} projector pixels, "
        "expected sigma {:.3f}; {} points rejected as too far",
        scan.epipolar->median, scan.epipolar->median_length, scan.epipolar->median_sigma,
        scan.epipolar->doubted);
  }
  if (scan.median_sigma) {
    output.say("  uncertainty of depth: median sigma {:.4g} mm", *scan.median_sigma);
  }
  std::vector<std::string> times;
  for (const auto& [name, words, seconds] : times_of(scan)) {
    times.push_back(fmt::format("{:.0f} {}", 1e3 * seconds, words));
  }
  output.say("  time: {}", fmt::join(times, ", "));
  for (const auto& [name, path] : scan.files.named()) output.say("  {}: {}", name, path);
}

}  // namespace slipstream::app
