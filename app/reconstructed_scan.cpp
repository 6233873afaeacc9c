#include "app/reconstructed_scan.h"

#include "app/process.h"
#include "slipstream/io/image_file.h"
#include "slipstream/reconstruct/coordinate_map.h"

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

/// Name in JSON, words and seconds of each step.
std::array<std::tuple<const char*, const char*, double>, 6> times_of(
    const ReconstructedScan& scan) {
  return {{{"read", "ms to read", scan.read},
           {"gamma", "for gamma", scan.sound.choosing},
           {"check", "to check", scan.sound.checking},
           {"tables", "for tables", scan.tables},
           {"reconstruct", "to reconstruct", scan.computed},
           {"write", "to write", scan.written}}};
}

void load_map(const ReconstructFlags& flags, LoadedScan& loaded) {
  const ScanFlags& given = flags.cloud;
  throw_if(!given.scanner, "--from needs the scanner's file: --scanner");

  const std::string& path = loaded.result.name.path;
  const Image<double> map = read_map(path);

  // The map has no scan.yaml: the flags alone describe the patterns.
  EngineSetup& setup = loaded.result.sound.setup;
  setup.sequence = changed({}, given.sequence);
  setup.settings = flags.cloud.settings;
  setup.scanner = completed(read_scanner(*given.scanner), given.scanner->string(), map.size(),
                            setup.sequence.projector);

  loaded.coordinates =
      naming(path, [&] { return coordinates_of_map(map, flags.from, projector_length(setup)); });

  throw_if(flags.modulation && flags.scans.size() > 1, "--from-modulation needs a single map");
  throw_if(!flags.modulation && flags.command->count("--min-modulation") > 0,
           "with --from, --min-modulation needs --from-modulation");
  if (flags.modulation) loaded.modulation = converted<float>(read_map(*flags.modulation));
}

/// Checks a scan of two cameras without a projector; the setup's scanner is then the pair.
SoundScan sound_pair(Scan& scan, const ScanName& name, const fs::path& file, CloudFlags flags,
                     Output& output) {
  const Scanner pair =
      completed(read_camera_pair(file), file.string() + ", the second camera as the projector",
                scan.frames.size(), scan.further_cameras.front().frames.size());
  PhotometricCalibration& known = flags.photometry;

  // Photometry given by flag goes before the file's.
  known.ambient = known.ambient ? known.ambient : pair.photometry.ambient;
  if (!known.noise_variance) {
    known.noise_variance = pair.photometry.noise_variance;
    known.noise_gain = pair.photometry.noise_gain;
  }

  // Without a projector the frames cannot check the calibration, so the check is the one for maps.
  SoundScan sound = sound_scan(scan, text_of(name), flags, output, Wanted::maps);
  sound.setup.scanner = pair;
  sound.setup.scanner.photometry = known;

  output.say("{}: two cameras, no projector: the calibration is not checked with the frames",
             text_of(name));

  return sound;
}

/// Returns the file of two cameras without a projector, if the scan has no scanner but that.
std::optional<fs::path> read_scan(const ScanFlags& input, const ReconstructFlags& flags,
                                  LoadedScan& loaded) {
  const auto& [path, window] = loaded.result.name;
  const bool cameras = !flags.one_camera, only_maps = flags.files.only_maps() && !flags.uncertainty;

  loaded.scan = load_checkable(path, input, cameras, loaded.result.words);
  const Scan& scan = loaded.scan;

  // Points need a scanner: the scan's own, or a calibrated pair of cameras without a projector.
  throw_if(input.second_scanner && scan.further_cameras.empty(),
           "{}: --second-scanner needs pictures of a second camera; name them with "
           "--second-camera",
           path);
  std::optional<fs::path> pair;
  if (!only_maps && !scan.scanner && !scan.further_cameras.empty()) {
    pair = scan_files_in(path, input).scanner;
  }
  throw_if(!only_maps && !scan.scanner && !pair,
           "{}: no scanner is known; name its file with --scanner or in scan.yaml", path);

  // Without a fringe order the frames give a phase, but no points.
  const bool only_phase = flags.files.coordinate.empty() && scan.further_cameras.empty() &&
                          !has_coordinate(scan.sequence.strategy);

  loaded.result.warnings = scan.warnings;
  loaded.result.wanted = only_maps && (!scan.scanner || only_phase) ? Wanted::maps : Wanted::points;
  return pair;
}

}  // namespace

LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output) {
  LoadedScan loaded;
  ReconstructedScan& result = loaded.result;
  result.name = name;
  result.words = output.held();
  result.entry = entry_for(name, flags.settings);

  Stopwatch watch;
  try {
    // The window and the open recording of this scan.
    ScanFlags input = flags.cloud;
    input.window = name.window;
    input.recording = opened.at(name.path);

    // 1. Skip the scan if the manifest lists it as done with the same input, settings and outputs.
    if (before != nullptr) {
      const ScanFiles map{.path = name.path, .frames = {name.path}, .scanner = input.scanner};
      result.entry["input"] = fmt::format(
          "{:08x}", checksum_of(flags.from.empty() ? scan_files_in(name.path, input) : map));
      const auto outputs = files_of_scan(flags.files, name).written();
      result.done_before = why_not_done(*before, name, result.entry, outputs).empty();
      if (result.done_before) return loaded;
    }

    // 2. A map of another program needs no check.
    if (!flags.from.empty()) {
      load_map(flags, loaded);
      result.read = watch.lap();
      return loaded;
    }

    // 3. Read the scan, choose its gamma and check it.
    const std::optional<fs::path> pair = read_scan(input, flags, loaded);
    result.read = watch.lap();
    result.sound =
        pair ? sound_pair(loaded.scan, name, *pair, flags.cloud, result.words)
             : sound_scan(loaded.scan, text_of(name), flags.cloud, result.words, result.wanted);
  } catch (const Error& error) {
    result.failure = error.what();
  } catch (const WorldError& error) {  // an unreadable file fails only its own scan
    if (flags.scans.size() == 1) throw;
    result.failure = error.what();
  }

  return loaded;
}

nlohmann::json document_of(const ReconstructedScan& scan) {
  nlohmann::json seconds;
  for (const auto& [name, words, time] : times_of(scan)) seconds[name] = time;

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
  for (const auto& [name, words, time] : times_of(scan)) seconds += time;
  entry["seconds"] = seconds;

  scan.failure.empty() ? entry["counts"] = as_json(scan.counts) : entry["error"] = scan.failure;
  return line_of(entry);
}

void tell(const ReconstructedScan& scan, Output& output) {
  output.say("{}: {} {} of {} pixels, backend {}", text_of(scan.name), scan.counts[0],
             scan.wanted == Wanted::maps ? "measured, no points," : "points",
             scan.cloud.validity.pixel_count(), scan.backend);

  // Why pixels were rejected.
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (scan.counts[i] == 0) continue;
    output.say("  rejected, {}: {}", name_of(static_cast<Validity>(i)), scan.counts[i]);
  }
  if (scan.counts[static_cast<std::size_t>(Validity::out_of_range)] > 0) {
    const auto [nearest, farthest] = depth_range(scan.sound.setup);
    output.say("  depths kept: {:.0f} to {:.0f} mm; change with --nearest, --farthest or --raw",
               nearest, farthest);
  }

  // Plausibility, for a look: a wrong calibration shows in the baseline and the depth.
  if (const double depth = scan.sound.checked.median_depth; depth > 0) {
    output.say("  baseline {:.4g} mm, median depth {:.4g} mm",
               scan.sound.setup.scanner.translation.norm(), depth);
  }

  // Errors: true, epipolar and predicted.
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

  // Time of each step, and the files.
  std::vector<std::string> times;
  for (const auto& [name, words, seconds] : times_of(scan)) {
    times.push_back(fmt::format("{:.0f} {}", 1e3 * seconds, words));
  }
  output.say("  time: {}", fmt::join(times, ", "));
  for (const auto& [name, path] : scan.files.named()) output.say("  {}: {}", name, path);
}

}  // namespace slipstream::app
