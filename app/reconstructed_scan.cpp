#include "app/reconstructed_scan.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "app/process.h"
#include "app/report_facts.h"
#include "base/numbers.h"
#include "base/stopwatch.h"
#include "check/map_check.h"
#include "geometry/map_form.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/pose_file.h"
#include "merge/fused_model.h"
#include "reconstruct/engine_setup.h"
#include "slipstream/scan_files.h"

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

/// Name in JSON, label and seconds of each step.
std::array<std::tuple<const char*, const char*, double>, 6> times_of(
    const ReconstructedScan& scan) {
  return {{{"read", "ms to read", scan.read},
           {"gamma", "for gamma", scan.result.choosing},
           {"check", "to check", scan.result.checking},
           {"tables", "for tables", scan.result.tables},
           {"reconstruct", "to reconstruct", scan.result.computing},
           {"write", "to write", scan.written}}};
}

/// The form of the maps: the patterns' origin and direction are of their values.
MapForm map_form_in(const ReconstructFlags& flags) {
  MapForm form = map_form_named(flags.from);
  const auto& settings = flags.changes.sequence.settings;

  const auto origin = settings.find("origin"), backwards = settings.find("backwards");
  if (origin != settings.end() && origin->second) {
    form.origin = SettingValue(*origin->second).number();
  }
  if (backwards != settings.end() && backwards->second) {
    SettingValue(*backwards->second).read(form.backwards);
  }
  return form;
}

/// The setup for maps of that size.
EngineSetup setup_for_map(const ReconstructFlags& flags, Size size) {
  const std::optional<fs::path>& scanner = flags.changes.scanner;
  throw_if(!scanner, "--from needs the scanner's file: --scanner");

  // No strategy made the map.
  SequenceChanges changes = flags.changes.sequence;
  changes.settings.erase("origin");
  changes.settings.erase("backwards");

  EngineSetup setup;
  setup.sequence = changed({}, changes);
  setup.settings = flags.job.reconstruct;
  setup.scanner =
      completed(read_scanner(*scanner), scanner->string(), size, setup.sequence.projector);
  return setup;
}

/// The coordinates whose pixels are bright enough.
Image<double> lit_coordinates(const LoadedScan& loaded) {
  Image<double> lit = loaded.coordinates;
  if (loaded.modulation.size() != lit.size()) return lit;

  const double least = loaded.job.setup.settings.minimum_modulation;
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    if (!(loaded.modulation.begin()[i] >= least)) lit.begin()[i] = nan;
  }
  return lit;
}

void load_map(const ReconstructFlags& flags, LoadedScan& loaded) {
  throw_if(flags.modulation && flags.scans.size() > 1, "--from-modulation needs a single map");
  throw_if(!flags.modulation && flags.command->count("--minimum-modulation") > 0,
           "with --from, --minimum-modulation needs --from-modulation");

  // 1. Read the map, without pixels that were invalid to the program that made it.
  const std::string& path = loaded.scan.name.path;
  const MapForm form = map_form_in(flags);
  Image<double> map = read_map(path);
  EngineSetup& setup = loaded.job.setup;
  setup = setup_for_map(flags, map.size());

  std::vector<Finding> shared = leave_out_shared_values(map);
  loaded.coordinates = naming(
      path, [&] { return coordinates_of_map(std::move(map), form, projector_length(setup)); });
  if (flags.modulation) loaded.modulation = converted<float>(read_map(*flags.modulation));

  // 2. Check it.
  require_valid(setup);
  CheckedScan& checked = loaded.job.checked;
  checked = check_map(lit_coordinates(loaded), form, setup.scanner, setup.sequence.axis);
  checked.findings.insert(checked.findings.begin(), shared.begin(), shared.end());
  refuse_or_warn(checked, text_of(loaded.scan.name), flags.job.keep_refused, loaded.scan.held);
}

/// Reads the scan, and chooses its kind of result.
Scan read_scan(const ScanChanges& input, const ReconstructFlags& flags, ReconstructedScan& result) {
  const std::string& path = result.name.path;
  Scan scan = load_checkable(path, input, !flags.one_camera, result.held);
  throw_if(!input.further_scanners.empty() && scan.further_cameras.empty(),
           "{}: --second-scanner needs pictures of a second camera; name them with "
           "--second-camera",
           path);

  const bool only_maps = flags.files.only_maps() && !flags.job.uncertainty;

  // Without a scanner a preview shows maps, and a scan without outputs is measured.
  const bool has_pair = scan.camera_pair && !scan.further_cameras.empty();
  const bool is_alone = !scan.scanner && !has_pair;
  const bool wants_points = flags.files.need_points() || flags.job.uncertainty;

  // Without a fringe order the frames give a phase, but no points.
  const bool only_phase = flags.files.coordinate.empty() && scan.further_cameras.empty() &&
                          !has_coordinate(scan.sequence.strategy);
  const bool gives_maps =
      (only_maps && (!scan.scanner || only_phase)) || (is_alone && !wants_points);
  result.output = gives_maps ? ScanOutput::maps : ScanOutput::points;
  result.warnings = scan.warnings;
  return scan;
}

/// The points of cameras that were fused.
void tell_fused(const ReconstructedScan& scan, Output& output) {
  const ScanResult& result = scan.result;
  const bool by_match = !has_coordinate(result.setup.sequence.strategy);
  const auto shared = std::ranges::count_if(
      result.fused->points, [](const ModelPoint& point) { return point.views > 1; });
  output.say(
      "{}: {} points, {:.3g} mm apart, of {} cameras with {} points; {} of them "
      "seen by two or more, {:.2g} mm apart in the median; {}:",
      text_of(scan.name), result.fused->points.size(), result.fused->spacing,
      result.points_of_cameras.size(), fmt::join(result.points_of_cameras, ", "), shared,
      quality_of(*result.fused).median_disagreement.value_or(0),
      by_match ? "their match" : "the first camera");
}

}  // namespace

LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output) {
  LoadedScan loaded;
  ReconstructedScan& result = loaded.scan;
  result.name = name;
  result.held = output.held();
  result.entry = entry_for(name, flags.settings);
  const std::shared_ptr<const FramePose>& frame = wanted_frame(flags.job.reconstruct);
  if (frame) result.entry["frame"] = text_of(*frame);

  Stopwatch watch;
  try {
    // The window and the open recording of this scan.
    ScanChanges input = flags.changes;
    input.window = name.window;
    input.recording = opened.at(name.path);
    if (input.window && !input.recording) input.folder = opened.folder_at(name.path);

    // 1. Skip the scan if the manifest lists it as done with the same input, settings and outputs.
    if (before != nullptr) {
      const ScanFiles map{.path = name.path, .frames = {name.path}, .scanner = input.scanner};
      result.entry["input"] = fmt::format(
          "{:08x}", checksum_of(flags.from.empty() ? scan_files_in(name.path, input) : map));
      const auto outputs = files_of_scan(flags.files, name).written();
      result.done_before = why_not_done(*before, name, result.entry, outputs).empty();
      if (result.done_before) return loaded;
    }

    // 2. A map of another program has no frames.
    if (!flags.from.empty()) {
      load_map(flags, loaded);
      result.read = watch.lap();
      return loaded;
    }
    Scan scan = read_scan(input, flags, result);
    result.read = watch.lap();
    const bool has_pair = !scan.scanner && scan.camera_pair;
    ScanJobSettings settings = flags.job;
    settings.output = result.output;
    loaded.job = checked_scan(std::move(scan), text_of(name), settings, result.held);
    if (has_pair && result.output == ScanOutput::points) {
      result.held.say(
          "{}: two cameras, no projector: the calibration is not checked with the frames",
          text_of(name));
    }
  } catch (const Error& error) {
    result.failure = with_flags(error.what());
  } catch (const WorldError& error) {  // an unreadable file fails only its own scan
    if (flags.scans.size() == 1) throw;
    result.failure = with_flags(error.what());
  }

  return loaded;
}

nlohmann::json document_of(const ReconstructedScan& scan) {
  const ScanResult& result = scan.result;
  nlohmann::json seconds;
  for (const auto& [name, label, time] : times_of(scan)) seconds[name] = time;

  const auto prediction = [&](double PredictedRms::*part) {
    return scan.predicted ? std::optional((*scan.predicted).*part) : std::nullopt;
  };

  std::size_t points = scan.output == ScanOutput::maps ? 0 : result.counts[0];
  if (result.fused) points = result.fused->points.size();
  nlohmann::json document = described(
      "scan", scan.name.path, "window", scan.name.window, "points", points, "pixels",
      result.cloud.validity.pixel_count(), "counts", result.counts, "backend", result.backend,
      "least_modulation", result.least_modulation, "corrected_for_contrast", result.pulled_pixels,
      "gamma", json_of(result.gamma), "baseline_mm", result.setup.scanner.translation.norm(),
      "median_depth_mm", scan.median_depth, "files", scan.files.named(), "median_sigma_z_mm",
      scan.median_sigma, "rms_mm", scan.rms, "predicted_mm", prediction(&PredictedRms::with_edges),
      "predicted_from_noise_mm", prediction(&PredictedRms::of_noise), "epipolar", result.epipolar,
      "guard", result.guard, "warnings", scan.warnings, "findings", result.checked.findings,
      "repairs", result.checked.repairs, "seconds", seconds);

  if (result.budget) document["budget"] = json_of(*result.budget);
  if (result.fused) {
    const ModelQuality quality = quality_of(*result.fused);
    describe(document, "points_of_cameras", result.points_of_cameras, "spacing_mm",
             result.fused->spacing, "median_sigma_mm", quality.median_sigma,
             "median_disagreement_mm", quality.median_disagreement);
  }

  // Only --anyway reconstructs a refused scan.
  if (any_wrong(result.checked.findings)) document["doubted"] = true;
  return document;
}

std::string line_of(const ReconstructedScan& scan) {
  nlohmann::json entry = scan.entry;
  double seconds = 0;
  for (const auto& [name, label, time] : times_of(scan)) seconds += time;
  entry["seconds"] = seconds;
  if (scan.failure.empty()) {
    entry["counts"] = as_json(scan.result.counts);
  } else {
    entry["error"] = scan.failure;
  }
  return line_of(entry);
}

std::string text_of(const PredictedRms& predicted) {
  return fmt::format("predicted: {:.4g} mm from noise, {:.4g} mm with edges{}", predicted.of_noise,
                     predicted.with_edges, predicted.is_of_edges() ? ", which dominate" : "");
}

void tell(const ReconstructedScan& scan, Output& output) {
  const ScanResult& result = scan.result;
  if (result.fused) tell_fused(scan, output);

  const std::string done = scan.output == ScanOutput::maps
                               ? fmt::format("measured {}", result.counts[0])
                               : fmt::format("{} points", result.counts[0]);
  output.say("{}: {} of {} pixels, backend {}", text_of(scan.name), done,
             result.cloud.validity.pixel_count(), result.backend);
  if (scan.output == ScanOutput::maps && !has_geometry(result.setup.scanner)) {
    output.say("  no points, as no scanner is known; name its file with --scanner");
  }
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (result.counts[i] == 0) continue;
    output.say("  rejected, {}: {}", name_of(static_cast<Validity>(i)), result.counts[i]);
  }
  if (result.counts[static_cast<std::size_t>(Validity::out_of_range)] > 0) {
    const auto [nearest, farthest] = depth_range(result.setup);
    output.say("  depths kept: {:.0f} to {:.0f} mm; change with --nearest, --farthest or --raw",
               nearest, farthest);
  }
  if (const double depth = scan.median_depth; depth > 0) {
    output.say("  baseline {:.4g} mm, median depth of the {} {:.4g} mm",
               result.setup.scanner.translation.norm(),
               result.counts[0] > 0 ? "points" : "pixels checked", depth);
  }

  if (result.pulled_pixels) {
    output.say("  corrected for contrast: {} pixels", *result.pulled_pixels);
  }

  // Errors: true, epipolar and predicted.
  if (scan.rms) {
    output.say("  RMS error against truth: {:.4g} mm{}", *scan.rms,
               scan.predicted ? "; " + text_of(*scan.predicted) : "");
  }
  if (result.epipolar) {
    output.say(
        "  distance from epipolar lines: median {:+.3f}, absolute {:.3f}, common to all {:.3f} "
        "projector pixels, expected sigma {:.3f}; {} points rejected as too far from the rest",
        result.epipolar->median, result.epipolar->median_length, result.epipolar->common,
        result.epipolar->median_sigma, result.epipolar->doubted);
  }
  if (result.guard) tell_guard(*result.guard, "  ", output);
  if (scan.median_sigma) {
    output.say("  uncertainty of depth: median sigma {:.4g} mm", *scan.median_sigma);
  }
  if (result.budget) {
    for (const auto& [source, value] : facts_of(*result.budget)) {
      output.say("    {:<13} {}", source, value);
    }
  }

  // Time of each step, and the files.
  std::vector<std::string> times;
  for (const auto& [name, label, seconds] : times_of(scan)) {
    times.push_back(fmt::format("{:.0f} {}", 1e3 * seconds, label));
  }
  output.say("  time: {}", fmt::join(times, ", "));
  for (const auto& [name, path] : scan.files.named()) output.say("  {}: {}", name, path);
}

}  // namespace slipstream::app
