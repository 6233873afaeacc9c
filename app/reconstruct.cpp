#include <deque>
#include <future>

#include "app/manifest.h"
#include "app/process.h"
#include "app/reconstruct_flags.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/surface.h"
#include "slipstream/decode/frame_motion.h"
#include "slipstream/io/file.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/reconstruct/epipolar.h"

namespace slipstream::app {
namespace {

/// One scan's results, as they are told.
struct ReconstructedScan {
  ScanName name;
  std::string failure;  ///< why there are none; else empty
  Output words{false};  ///< what is said of it, until its turn comes
  Cloud cloud;
  ValidityCounts counts{};
  Maps maps;  ///< where asked for
  std::optional<Uncertainty> uncertainty;
  std::optional<EpipolarCheck> epipolar;  ///< of a scan along both axes
  std::string backend;
  std::vector<std::string> warnings;
  SoundScan sound;
  ResultFiles files;                                       ///< written
  std::optional<double> rms, median_sigma;                 ///< mm
  double least_modulation = 0;                             ///< of a point, grey levels of 255
  double read = 0, tables = 0, computed = 0, written = 0;  ///< s
  bool done_before = false;                                ///< nothing else is told then
  nlohmann::json entry;                                    ///< of the manifest
};

/// What was done, as it is done.
struct ManifestLog {
  ManifestLog(const std::string& path, Output& output)
      : file(path, [&] { output.warn(path + ": another run writes it; waiting for its end"); }),
        before(read_manifest(path)) {
    file.cut(before.whole_bytes);
  }

  GrowingFile file;
  Manifest before;
};

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

nlohmann::json document_of(const ReconstructedScan& scan) {
  nlohmann::json seconds;
  for (const ScanTime& time : times_of(scan)) seconds[time.name] = time.seconds;
  std::optional<nlohmann::json> epipolar;
  if (scan.epipolar) {
    epipolar = described("median_px", scan.epipolar->median, "median_length_px",
                         scan.epipolar->median_length, "median_sigma_px",
                         scan.epipolar->median_sigma, "doubted", scan.epipolar->doubted);
  }
  nlohmann::json told = described(
      "scan", scan.name.path, "window", scan.name.window, "points", scan.counts[0], "pixels",
      scan.cloud.validity.pixel_count(), "counts", scan.counts, "backend", scan.backend,
      "least_modulation", scan.least_modulation, "gamma", json_of(scan.sound.gamma), "files",
      scan.files.named(), "median_sigma_z_mm", scan.median_sigma, "rms_mm", scan.rms, "epipolar",
      epipolar, "warnings", scan.warnings, "findings", scan.sound.checked.findings, "repairs",
      scan.sound.checked.repairs, "seconds", seconds);
  // Only what --anyway went on with is wrong and was reconstructed.
  if (any_wrong(scan.sound.checked.findings)) told["doubted"] = true;
  return told;
}

void tell(const ReconstructedScan& scan, Output& output) {
  output.say("{}: {} points of {} pixels, backend {}", text_of(scan.name), scan.counts[0],
             scan.cloud.validity.pixel_count(), scan.backend);
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (scan.counts[i] == 0) continue;
    output.say("  left out, {}: {}", name_of(static_cast<Validity>(i)), scan.counts[i]);
  }
  if (scan.counts[static_cast<std::size_t>(Validity::out_of_range)] > 0) {
    const auto [nearest, farthest] = depth_range(scan.sound.setup);
    output.say("  depths kept: {:.0f} to {:.0f} mm; --nearest, --farthest and --raw change that",
               nearest, farthest);
  }
  if (scan.rms) output.say("  RMS error against truth: {:.4g} mm", *scan.rms);
  if (scan.epipolar) {
    output.say(
        "  from epipolar lines: median {:+.3f}, without signs {:.3f} projector pixels, sigma by "
        "noise {:.3f}; {} points were too far and left out",
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

void require_uncertainty_possible(const ReconstructFlags& flags, const EngineSetup& setup,
                                  bool two_cameras) {
  if (!flags.uncertainty) return;
  throw_if(two_cameras, "--uncertainty is of one camera and the projector; add --one-camera");
  throw_if(!setup.scanner.photometry.noise_variance.has_value(),
           "the scanner file has no noise variance in it, which --uncertainty needs; measure it "
           "with slipstream calibrate noise, or give --noise-variance");
}

void match_cameras(const ReconstructFlags& flags, const Scan& scan, const EngineSetup& setup,
                   ReconstructedScan& result) {
  const Scan& second = scan.further_cameras.front();
  const PhaseMatcher match(setup.scanner, setup_for(second).scanner, setup.sequence, setup.settings,
                           flags.match);
  PhaseMatcher::Result matched = match(scan.frames, second.frames);
  result.cloud = std::move(matched.cloud);
  result.maps = std::move(matched.maps);
  result.backend = match.method_for(scan.frames);
}

void compute(const ReconstructFlags& flags, const Scan& scan, Engine& engine,
             ReconstructedScan& result) {
  if (!scan.other_axis.empty()) {
    engine.cloud_and_maps(scan.frames, result.cloud, result.maps);
    result.epipolar =
        check_epipolar(engine.setup(), scan.other_axis.front(), result.maps, result.cloud);
  } else if (flags.files.any_map() || flags.uncertainty) {
    engine.cloud_and_maps(scan.frames, result.cloud, result.maps);
  } else {
    engine.cloud(scan.frames, result.cloud);
  }
  result.backend = engine.backend_for(scan.frames);
}

void add_finding(Finding finding, ReconstructedScan& result) {
  result.words.warn(fmt::format("{}: {}", text_of(result.name), text_of(finding)));
  result.sound.checked.findings.push_back(std::move(finding));
}

/// What both axes say of the calibration.
Finding contradiction(const EpipolarCheck& check) {
  return {.what = "the coordinates along x and y are not those of one projector pixel",
          .evidence = {{"median distance from the epipolar lines, projector pixels",
                        check.median_length},
                       {"sigma by noise", check.median_sigma}},
          .likely =
              "camera or projector moved since they were calibrated, or frames are in a wrong "
              "order",
          .advice =
              "calibrate again: slipstream calibrate geometry; patterns along x alone are not held "
              "to this"};
}

/// What the check does not see by its pixels, or leaves to --nearest and --farthest.
Finding no_points(const ValidityCounts& counts) {
  const auto most = std::max_element(counts.begin() + 1, counts.end()) - counts.begin();
  return {.what = "not one pixel became a point",
          .likely = fmt::format("{} in most of them", name_of(static_cast<Validity>(most))),
          .advice = "look at the frames with slipstream view"};
}

/// The cloud with its normals and uncertainty on the grid asked for; maps and preview on the
/// camera's.
void write_files(const ReconstructFlags& flags, const ReconstructedScan& scan) {
  ResultFiles maps = scan.files;
  maps.cloud.clear();
  write_results(maps, scan.cloud, scan.maps, {});
  std::optional<Normals> normals;
  if (flags.normals && !scan.files.cloud.empty()) normals = smoothed_normals(scan.cloud);
  std::optional<Uncertainty> uncertainty = scan.uncertainty;
  const auto thin = [&](auto&... images) { ((images = subsampled(images, flags.subsample)), ...); };
  if (normals) thin(normals->x, normals->y, normals->z);
  if (uncertainty) {
    thin(uncertainty->coordinate, uncertainty->x, uncertainty->y, uncertainty->z);
  }
  std::optional<Cloud> coarse;
  if (flags.subsample > 1) coarse = subsampled(scan.cloud, flags.subsample);
  write_results({.cloud = scan.files.cloud}, coarse ? *coarse : scan.cloud, {},
                {.normals = normals ? &*normals : nullptr,
                 .uncertainty = uncertainty ? &*uncertainty : nullptr,
                 .remarks = doubts(scan.sound.checked.findings)});
}

bool measures_motion(const EngineSetup& setup) {
  return MotionMeasurement::is_possible(measuring_band(setup.sequence.strategy.layout()));
}

/// A scan as it was read, and what is known of its results then.
struct LoadedScan {
  Scan scan;
  ReconstructedScan result;
};

LoadedScan loaded_scan(const ScanName& name, const ReconstructFlags& flags, const Manifest* before,
                       OpenedRecording& opened, const Output& output) {
  LoadedScan loaded;
  ReconstructedScan& result = loaded.result;
  result.name = name;
  result.words = output.held();
  result.entry = entry_for(name, flags.settings);
  Stopwatch watch;
  try {
    ScanFlags input = flags.cloud;
    input.window = name.window;
    input.recording = opened.at(name.path);
    if (before != nullptr) {
      const ScanFiles files = scan_files_in(name.path, input);
      result.entry["input"] = fmt::format("{:08x}", checksum_of(files));
      const auto outputs = files_of_scan(flags.files, name).written();
      result.done_before = why_not_done(*before, name, result.entry, outputs).empty();
      if (result.done_before) return loaded;
    }
    loaded.scan = load(name.path, input, !flags.one_camera, result.words);
    result.warnings = loaded.scan.warnings;
    result.read = watch.lap();
    result.sound = sound_scan(loaded.scan, text_of(name), flags.cloud, result.words);
  } catch (const Error& error) {
    result.failure = error.what();
  } catch (const WorldError& error) {  // a file that the disk does not give ends no others
    if (flags.scans.size() == 1) throw;
    result.failure = error.what();
  }
  return loaded;
}

/// What one scan leaves to the next.
struct Reused {
  std::optional<Engine> engine;
  bool fallback_told = false;
  std::vector<Cloud> clouds;
};

void reconstruct_scan(Scan& scan, ReconstructedScan& result, const ReconstructFlags& flags,
                      Reused& reused) {
  std::optional<Engine>& engine = reused.engine;
  Output& output = result.words;
  if (!reused.clouds.empty()) {
    result.cloud = std::move(reused.clouds.back());
    reused.clouds.pop_back();
  }
  // The system makes the pages of a new cloud as slowly as the engine its tables.
  auto memory =
      std::async(parallel_threads() == 1 ? std::launch::deferred : std::launch::async, [&] {
        const Size size = scan.frames.size();
        if (result.cloud.size() != size) result.cloud = Cloud(size);
      });
  Stopwatch watch;
  const EngineSetup& setup = result.sound.setup;
  const bool two_cameras = !scan.further_cameras.empty();
  require_uncertainty_possible(flags, setup, two_cameras);
  throw_if(!flags.files.epipolar.empty() && (two_cameras || scan.other_axis.empty()),
           "--epipolar is of one camera and patterns along both axes: --axis both");
  throw_if(!flags.files.motion.empty() && (two_cameras || !measures_motion(setup)),
           "--motion-map is of one camera and frames beyond a cycle: --motion 2");
  result.least_modulation =
      two_cameras ? flags.cloud.settings.minimum_modulation : least_modulation(setup);
  if (result.least_modulation > flags.cloud.settings.minimum_modulation) {
    output.say("{}: least modulation {:.1f} instead of {:.1f}, where noise hides the fringe order",
               text_of(result.name), result.least_modulation,
               flags.cloud.settings.minimum_modulation);
  }
  if (!two_cameras && (!engine || engine->setup() != setup)) {
    engine.emplace(setup);  // else its tables serve again
  }
  result.tables = watch.lap();
  if (!result.sound.gamma.sentence.empty()) {
    output.say("{}: {}", text_of(result.name), result.sound.gamma.sentence);
  }
  memory.get();
  two_cameras ? match_cameras(flags, scan, setup, result) : compute(flags, scan, *engine, result);
  if (engine && !reused.fallback_told) {
    reused.fallback_told = warn_of_fallback(engine->fallback_reason(), output);
  }
  if (result.epipolar && result.epipolar->contradicts())
    add_finding(contradiction(*result.epipolar), result);
  result.counts = count_by_validity(result.cloud);
  if (result.counts[0] == 0) add_finding(no_points(result.counts), result);
  result.computed = watch.lap();
  if (flags.uncertainty) {
    result.uncertainty = engine->uncertainty(result.cloud, result.maps, scan.frames);
    result.median_sigma = median_depth(*result.uncertainty);
  }
  result.files = files_of_scan(flags.files, result.name);
  result.rms = error_against_truth(result.name.path, result.cloud);
}

ReconstructedScan reconstructed(LoadedScan loaded, const ReconstructFlags& flags, Reused& reused) {
  ReconstructedScan& result = loaded.result;
  if (result.done_before || !result.failure.empty()) return std::move(result);
  try {
    reconstruct_scan(loaded.scan, result, flags, reused);
  } catch (const Error& error) {
    result.failure = error.what();
  }
  return std::move(result);
}

ReconstructedScan written(ReconstructedScan result, const ReconstructFlags& flags) {
  if (result.done_before || !result.failure.empty()) return result;
  Stopwatch watch;
  write_files(flags, result);
  if (!flags.manifest.empty()) result.entry["outputs"] = sums_of(result.files.written());
  result.written = watch.lap();
  result.maps = {};
  result.uncertainty.reset();
  return result;
}

std::string line_of(const ReconstructedScan& scan) {
  nlohmann::json entry = scan.entry;
  double seconds = 0;
  for (const ScanTime& time : times_of(scan)) seconds += time.seconds;
  entry["seconds"] = seconds;
  if (!scan.failure.empty()) entry["error"] = scan.failure;
  if (scan.failure.empty()) entry["counts"] = as_json(scan.counts);
  return app::line_of(entry);
}

/// One that failed ends the program where it is the only one.
void tell(const ReconstructedScan& scan, bool only_one, Output& output) {
  output.release(scan.words);
  if (scan.failure.empty()) {
    if (output.is_json()) output.list("scans").push_back(document_of(scan));
    return tell(scan, output);
  }
  if (only_one) {
    output.document.update(scan.words.document);  // the findings that it was refused for
    throw Error(scan.failure);
  }
  nlohmann::json failed = described("scan", text_of(scan.name), "error", scan.failure);
  failed.update(scan.words.document);
  output.list("scans").push_back(std::move(failed));
  output.tell_failure(scan.failure);
  output.exit_code = 2;
}

/// Each scan as if it were alone, told in the order given; while one is reconstructed, those after
/// it are read and those before it are written. On one thread one after another.
void reconstruct_in_turn(const ReconstructFlags& flags, ManifestLog* log, Output& output) {
  const std::size_t count = flags.scans.size();
  const auto threads = static_cast<std::size_t>(count == 1 ? 1 : parallel_threads());
  const auto start = threads == 1 ? std::launch::deferred : std::launch::async;
  // Who writes waits for the disk more than for a core.
  const std::size_t most_written = threads == 1 ? 0 : threads;
  OpenedRecording opened;
  std::deque<std::future<LoadedScan>> loading;
  std::deque<std::future<ReconstructedScan>> writing;
  Reused reused;
  Progress progress("scans", count);
  const auto next_of = [](auto& waiting) {
    auto next = waiting.front().get();
    waiting.pop_front();
    return next;
  };
  std::size_t done_before = 0;
  const auto tell_next = [&] {
    ReconstructedScan scan = next_of(writing);
    progress.finish();
    const bool already = scan.done_before;
    if (log != nullptr && !scan.done_before) log->file.append(line_of(scan));
    scan.done_before ? static_cast<void>(++done_before) : tell(scan, count == 1, output);
    reused.clouds.push_back(std::move(scan.cloud));
    progress.advance(already);
  };
  for (std::size_t i = 0, asked = 0; i < count; ++i) {
    for (; asked < std::min(i + threads, count); ++asked) {
      loading.push_back(std::async(start, [&flags, &output, &opened, log,
                                           &name = flags.scans[asked]] {
        return loaded_scan(name, flags, log != nullptr ? &log->before : nullptr, opened, output);
      }));
    }
    writing.push_back(std::async(
        start, [&flags, scan = reconstructed(next_of(loading), flags, reused)]() mutable {
          return written(std::move(scan), flags);
        }));
    while (writing.size() > most_written) tell_next();
  }
  while (!writing.empty()) tell_next();
  if (log == nullptr) return;
  output.document["done_before"] = done_before;
  if (done_before > 0) output.say("{} of {} scans were done before", done_before, count);
}

void reconstruct(const ReconstructFlags& given, Output& output) {
  ReconstructFlags flags = given;
  flags.scans = scan_names(listed_scans(flags), flags.every);
  flags.settings = arguments_of(*flags.command, Arguments::settings);
  reconstruct_scans(std::move(flags), output);
}

}  // namespace

void reconstruct_scans(ReconstructFlags flags, Output& output) {
  require_writable(flags.files, flags.scans);
  require_valid(flags);
  keep_memory();
  output.document["scans"] = nlohmann::json::array();
  throw_if(!flags.resume && !flags.manifest.empty() && fs::exists(flags.manifest),
           "{}: is there already; --resume goes on with it", flags.manifest);
  std::optional<ManifestLog> log;
  if (!flags.manifest.empty()) log.emplace(flags.manifest, output);
  reconstruct_in_turn(flags, log ? &*log : nullptr, output);
  if (flags.files.named().empty()) {
    output.say("nothing was asked to be written; -o cloud.ply writes the cloud");
  }
}

void add_reconstruct(const Commands& program) {
  const auto [command, flags] =
      program.add(reconstruct, "reconstruct", "scans to cloud, depth, phase, preview");
  add_scans_flags(command, flags);
  command.add_output("--manifest", flags.manifest,
                     "what was done, as it is done, a line of JSON for each scan");
  command
      .add("--resume", flags.resume,
           "leave out what the manifest says is done, if input, settings and outputs are as then")
      ->needs("--manifest");
  add_reconstruct_flags(command.app, flags);
  command.examples({"reconstruct scan -o cloud.ply --depth depth.tiff --preview preview.png",
                    "reconstruct frames --strategy dual-frequency --steps 3 --high 16 --low 1 "
                    "--axis x --projector 1824x1140 --scanner scanner.yaml -o cloud.ply"},
                   "Several scans: {name} in a path stands for each scan's name, as in -o "
                   "clouds/{name}.ply\nWhole recordings: slipstream reconstruct scan.slip "
                   "--windows : -o clouds/{name}-{window}.ply");
}

}  // namespace slipstream::app
