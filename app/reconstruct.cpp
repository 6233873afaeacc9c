#include <deque>
#include <future>
#include <numeric>

#include "app/process.h"
#include "app/reconstructed_scan.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/cloud/surface.h"
#include "slipstream/decode/frame_motion.h"
#include "slipstream/io/image_file.h"
#include "slipstream/reconstruct/coordinate_map.h"
#include "slipstream/reconstruct/coordinate_matcher.h"

namespace slipstream::app {
namespace {

/// The manifest as it grows.
struct ManifestLog {
  ManifestLog(const std::string& path, Output& output)
      : file(path,
             [&] {
               output.warn(path + ": another run is writing it; waiting for that run to end");
             }),
        before(read_manifest(path)) {
    // Cuts off the line that a killed run left half-written.
    file.cut(before.whole_bytes);
  }

  GrowingFile file;
  Manifest before;
};

void require_uncertainty_possible(const EngineSetup& setup, bool two_cameras, Output& output) {
  throw_if(two_cameras, "--uncertainty works with one camera and the projector; add --one-camera");
  if (!setup.scanner.photometry.noise_variance) {
    output.warn(
        "--uncertainty: noise variance unknown, 1.6 assumed; measure it with slipstream calibrate "
        "noise, or give --noise-variance");
  }
}

void add_finding(Finding finding, ReconstructedScan& result) {
  result.words.warn(fmt::format("{}: {}", text_of(result.name), text_of(finding)));
  result.sound.checked.findings.push_back(std::move(finding));
}

void match_cameras(const ReconstructFlags& flags, const Scan& scan, const EngineSetup& setup,
                   ReconstructedScan& result) {
  const Scan& second = scan.further_cameras.front();

  // 1. Two cameras and an uncalibrated projector: pixels are matched by their projector coordinate.
  if (!scan.scanner) {
    CoordinateMatcher::Result matched =
        CoordinateMatcher(setup.scanner, setup.sequence, setup.settings)(scan);
    result.cloud = std::move(matched.cloud);
    result.maps = std::move(matched.maps);
    if (flags.uncertainty) result.uncertainty = std::move(matched.uncertainty);
    result.backend = "coordinates";
    return;
  }

  // 2. Two cameras calibrated with the same projector: pixels are matched by their wrapped phase.
  throw_if(!second.scanner,
           "the second camera's scanner is unknown; name its file with --second-scanner");
  PhaseMatcher match(setup.scanner, setup_for(second).scanner, setup.sequence, setup.settings,
                     flags.match);
  PhaseMatcher::Result matched = match(scan, second);

  // A band of many periods leaves the fringe order open. The cameras settle it by the depths on
  // which they agree, unless --nearest and --farthest limit the depths already.
  const bool limited = setup.settings.nearest && setup.settings.farthest;
  if (matched.agreement && matched.agreement->phase_shift != 0) {
    add_finding(wrong_origin(setup.sequence.strategy, matched.agreement->phase_shift), result);
  } else if (!matched.agreement && !has_coordinate(setup.sequence.strategy) && !limited) {
    add_finding({.what = "the cameras do not agree on the fringe order of most surfaces",
                 .likely = "several orders fit at the depths tried, or the calibration does not",
                 .advice = "name the depths, mm, between which everything lit lies: --nearest "
                           "NUMBER --farthest NUMBER"},
                result);
  }

  result.cloud = std::move(matched.cloud);
  result.maps = std::move(matched.maps);
  result.backend = match.method_for(scan.frames);
}

void compute(const ReconstructFlags& flags, const Scan& scan, Engine& engine,
             ReconstructedScan& result) {
  // Without a scanner or a fringe order only the light of the pixels can be judged.
  if (result.wanted == Wanted::maps) {
    engine.maps(scan.frames, result.maps);
    result.cloud = Cloud();
    result.cloud.validity =
        picture_report(engine.merged(scan.frames), result.maps, engine.setup().settings).validity;
  } else if (!scan.other_axis.empty()) {
    // Patterns along the other axis check the calibration.
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

/// Checks the calibration by patterns along both axes.
Finding contradiction(const EpipolarCheck& check) {
  return {
      .what = "the coordinates along x and y do not meet in one projector pixel",
      .evidence = {{"median distance from the epipolar lines, projector pixels",
                    check.median_length},
                   {"expected sigma", check.median_sigma}},
      .likely = "the camera or projector moved since calibration, or frames are in the wrong order",
      .advice =
          "calibrate again with slipstream calibrate geometry; scans along x alone do not show "
          "this"};
}

/// No point, or under half of the pixels that are lit and within the user's limits.
std::optional<Finding> missing_points(ValidityCounts counts, const ReconstructSettings& settings) {
  const std::size_t points = counts.front();
  const auto ignore = [&](Validity kind, bool if_true = true) {
    if (if_true && points > 0) counts[static_cast<std::size_t>(kind)] = 0;
  };

  // Pixels without light, and those that the user's own limits remove, are not missing.
  ignore(Validity::too_dark);
  ignore(Validity::outside_region);
  ignore(Validity::out_of_range, settings.nearest || settings.farthest);
  ignore(Validity::low_trust, settings.clean.largest_sigma.has_value());

  // Everything that is left counts as lit.
  const std::size_t lit = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  if (2 * points >= lit) return std::nullopt;

  // The most frequent reason for rejection; the first entry counts the points.
  const auto most = std::max_element(counts.begin() + 1, counts.end()) - counts.begin();
  return Finding{
      .what = points == 0 ? "not one pixel became a point"
                          : "under 50 % of the lit pixels became points",
      .evidence = {{"share", static_cast<double>(points) / static_cast<double>(lit)}},
      .likely = fmt::format("most are rejected: {}", name_of(static_cast<Validity>(most))),
      .advice = "look at the frames with slipstream view"};
}

/// Writes the cloud with normals and uncertainty on the requested grid; maps and preview on the
/// camera's.
void write_files(const ReconstructFlags& flags, const ReconstructedScan& scan) {
  ResultFiles maps = scan.files;
  maps.cloud.clear();
  write_results(maps, scan.cloud, scan.maps, {});

  // Normals come from neighbouring pixels, so they are computed before thinning.
  std::optional<Normals> normals;
  if (flags.normals && !scan.files.cloud.empty()) normals = smoothed_normals(scan.cloud);
  std::optional<Uncertainty> uncertainty = scan.uncertainty;
  const auto thin = [&](auto&... images) { ((images = subsampled(images, flags.subsample)), ...); };
  if (normals) thin(normals->x, normals->y, normals->z);
  if (uncertainty) thin(uncertainty->coordinate, uncertainty->x, uncertainty->y, uncertainty->z);

  std::optional<Cloud> coarse;
  if (flags.subsample > 1) coarse = subsampled(scan.cloud, flags.subsample);
  write_results({.cloud = scan.files.cloud}, coarse ? *coarse : scan.cloud, {},
                {.normals = normals ? &*normals : nullptr,
                 .uncertainty = uncertainty ? &*uncertainty : nullptr,
                 .remarks = doubts(scan.sound.checked.findings)});
}

/// Counts the points, warns of missing ones, and compares with the truth.
void judge(const ReconstructFlags& flags, ReconstructedScan& result) {
  result.files = files_of_scan(flags.files, result.name);
  result.counts = count_by_validity(result.cloud.validity);

  if (result.wanted == Wanted::maps) return;
  if (auto missing = missing_points(result.counts, flags.cloud.settings)) {
    add_finding(std::move(*missing), result);
  }
  result.rms = error_against_truth(result.name.path, result.cloud);
}

/// The RMS of depth that the noise of the frames predicts, mm. Only the virtual scanner's scans,
/// whose error is known, are worth the time.
std::optional<double> predicted_rms(const Scan& scan, Engine& engine,
                                    const ReconstructedScan& result) {
  if (!result.rms || !engine.setup().scanner.photometry.noise_variance) return std::nullopt;
  Maps maps;
  engine.maps(scan.frames, maps);

  // The sigma is NaN where a pixel has no point.
  double squares = 0;
  for (const float sigma : engine.uncertainty(result.cloud, maps, scan.frames).z) {
    if (std::isfinite(sigma)) squares += static_cast<double>(sigma) * sigma;
  }

  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(result.counts[0], 1)));
}

/// State passed from one scan to the next.
struct Reused {
  std::optional<Engine> engine;
  bool fallback_told = false;
  std::vector<Cloud> clouds;
};

void reconstruct_scan(Scan& scan, ReconstructedScan& result, const ReconstructFlags& flags,
                      Reused& reused) {
  std::optional<Engine>& engine = reused.engine;
  Output& output = result.words;

  // The memory of a cloud that is already written.
  if (!reused.clouds.empty()) {
    result.cloud = std::move(reused.clouds.back());
    reused.clouds.pop_back();
  }

  // Getting a new cloud's memory pages takes as long as building the engine's tables.
  auto memory =
      std::async(parallel_threads() == 1 ? std::launch::deferred : std::launch::async, [&] {
        const Size size = scan.frames.size();
        if (result.cloud.size() != size) result.cloud = Cloud(size);
      });

  Stopwatch watch;
  const EngineSetup& setup = result.sound.setup;
  const bool two_cameras = !scan.further_cameras.empty() && result.wanted == Wanted::points;

  // 1. Refuse flags that this scan cannot serve.
  if (flags.uncertainty) require_uncertainty_possible(setup, two_cameras && scan.scanner, output);
  throw_if(!flags.files.epipolar.empty() && (two_cameras || scan.other_axis.empty()),
           "--epipolar needs one camera and patterns along both axes: --axis both");
  throw_if(!flags.files.motion.empty() &&
               (two_cameras ||
                !MotionMeasurement::is_possible(measuring_band(setup.sequence.strategy.layout()))),
           "--motion-map needs one camera and extra frames: --motion 2");

  // 2. Raise the minimum modulation to where noise would hide the fringe order.
  result.least_modulation =
      two_cameras ? flags.cloud.settings.minimum_modulation : least_modulation(setup);
  if (result.least_modulation > flags.cloud.settings.minimum_modulation) {
    output.say(
        "{}: minimum modulation is {:.1f} instead of {:.1f}: below it noise hides the fringe order",
        text_of(result.name), result.least_modulation, flags.cloud.settings.minimum_modulation);
  }

  // 3. Build the engine's tables, unless the last scan had the same setup.
  if (!two_cameras && (!engine || engine->setup() != setup)) {
    engine.emplace(setup);  // otherwise its tables are reused
  }
  result.tables = watch.lap();

  if (!result.sound.gamma.sentence.empty()) {
    output.say("{}: {}", text_of(result.name), result.sound.gamma.sentence);
  }

  // 4. Reconstruct, once the cloud has its memory.
  memory.get();
  two_cameras ? match_cameras(flags, scan, setup, result) : compute(flags, scan, *engine, result);

  if (engine && !reused.fallback_told) {
    const bool chosen = setup.settings.engine != EngineKind::automatic;
    reused.fallback_told = tell_fallback(engine->fallback_reason(), chosen, output);
  }

  // 5. Judge the result: calibration, missing points, error against the ground truth, uncertainty.
  if (result.epipolar && result.epipolar->contradicts())
    add_finding(contradiction(*result.epipolar), result);
  judge(flags, result);
  result.computed = watch.lap();

  if (engine) result.predicted = predicted_rms(scan, *engine, result);
  if (flags.uncertainty) {
    if (!result.uncertainty) {
      result.uncertainty = engine->uncertainty(result.cloud, result.maps, scan.frames);
    }
    result.median_sigma = median_depth(*result.uncertainty);
  }

  // 6. The map of projector coordinates; two cameras bring their own with the match.
  if (!flags.files.coordinate.empty() && !two_cameras) {
    result.maps.coordinate =
        converted<float>(measured_coordinates(*engine, scan.frames, result.maps));
  }
}

void reconstruct_map(LoadedScan& loaded, const ReconstructFlags& flags) {
  ReconstructedScan& result = loaded.result;
  Stopwatch watch;

  result.cloud = cloud_of_coordinates(loaded.coordinates, result.sound.setup, loaded.modulation);
  result.maps.coordinate = converted<float>(loaded.coordinates);
  result.backend = "reference";

  judge(flags, result);
  result.computed = watch.lap();
}

ReconstructedScan reconstructed(LoadedScan loaded, const ReconstructFlags& flags, Reused& reused) {
  ReconstructedScan& result = loaded.result;
  if (result.done_before || !result.failure.empty()) return std::move(result);

  try {
    flags.from.empty() ? reconstruct_scan(loaded.scan, result, flags, reused)
                       : reconstruct_map(loaded, flags);
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

  // The cloud stays: its memory serves a later scan.
  result.written = watch.lap();
  result.maps = {};
  result.uncertainty.reset();

  return result;
}

/// A failure ends the program if it is the only scan.
void tell(const ReconstructedScan& scan, bool only_one, Output& output) {
  output.release(scan.words);

  if (scan.failure.empty()) {
    if (output.is_json()) output.list("scans").push_back(document_of(scan));
    return tell(scan, output);
  }

  if (only_one) {
    output.document.update(scan.words.document);  // the diagnostics that refused it
    throw Error(scan.failure);
  }

  // One of several scans: the others go on, and the exit code says that one has failed.
  nlohmann::json failed = described("scan", text_of(scan.name), "error", scan.failure);
  failed.update(scan.words.document);
  output.list("scans").push_back(std::move(failed));
  output.tell_failure(scan.failure);
  output.exit_code = 2;
}

/// Reconstructs each scan as if alone and prints results in the given order; while one is
/// reconstructed, later ones are read and earlier ones written. One after the other on a single
/// thread.
void reconstruct_in_turn(const ReconstructFlags& flags, ManifestLog* log, Output& output) {
  const std::size_t count = flags.scans.size();
  const auto threads = static_cast<std::size_t>(count == 1 ? 1 : parallel_threads());
  const auto start = threads == 1 ? std::launch::deferred : std::launch::async;

  // Writers wait for the disk more than for a core.
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

  // Waits for the files of the oldest scan, then logs and prints it and keeps its cloud's memory.
  std::size_t done_before = 0;
  const auto tell_next = [&] {
    ReconstructedScan scan = next_of(writing);

    // Removes the bar, so that the scan's lines do not overwrite it.
    progress.finish();
    if (log != nullptr && !scan.done_before) log->file.append(line_of(scan));
    scan.done_before ? static_cast<void>(++done_before) : tell(scan, count == 1, output);

    reused.clouds.push_back(std::move(scan.cloud));
    progress.advance(scan.done_before);
  };

  // Three stages overlap: scan i is reconstructed, later ones are read, earlier ones written.
  for (std::size_t i = 0, asked = 0; i < count; ++i) {
    for (; asked < std::min(i + threads, count); ++asked) {
      loading.push_back(std::async(start, [&flags, &output, &opened, log,
                                           &name = flags.scans[asked]] {
        return loaded_scan(name, flags, log != nullptr ? &log->before : nullptr, opened, output);
      }));
    }

    // The capture is initialised on this thread: it reconstructs; the task only writes the files.
    writing.push_back(std::async(
        start, [&flags, scan = reconstructed(next_of(loading), flags, reused)]() mutable {
          return written(std::move(scan), flags);
        }));

    while (writing.size() > most_written) tell_next();
  }

  while (!writing.empty()) tell_next();
  if (log == nullptr) return;
  output.document["done_before"] = done_before;
  if (done_before > 0) output.say("{} of {} scans were already done", done_before, count);
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
           "{}: already exists; use --resume to continue it", flags.manifest);

  std::optional<ManifestLog> log;
  if (!flags.manifest.empty()) log.emplace(flags.manifest, output);

  reconstruct_in_turn(flags, log ? &*log : nullptr, output);
  if (flags.files.named().empty()) output.say("nothing was written; -o cloud.ply writes the cloud");
}

void add_reconstruct(const Commands& program) {
  const auto [command, flags] = program.add(
      reconstruct, "reconstruct", "reconstruct scans: clouds, depth maps, phase maps, previews");

  // The scans, and the log with which an interrupted run can be resumed.
  add_scans_flags(command, flags);
  command.add_output("--manifest", flags.manifest, "log of finished scans, one JSON line each");
  command
      .add("--resume", flags.resume,
           "skip scans that the manifest lists as done with the same input, settings and outputs")
      ->needs("--manifest");

  add_reconstruct_flags(command.app, flags);

  // Maps of another program replace the frames, so flags about frames do not apply.
  command.add("--from", flags.from,
              fmt::format("read maps of another program, .tiff or .npy, NaN where invalid, instead "
                          "of scans: {}",
                          map_forms));
  command
      .add_file("--from-modulation", flags.modulation,
                "with --from: the map's modulation, grey levels of 255, for --min-modulation and "
                "cleaning")
      ->needs("--from");

  command.exclude("--from", {"--windows", "--strategy", "--steps", "--high", "--low", "--frequency",
                             "--periods", "--order", "--exposures", "--motion", "--gamma",
                             "--camera-bits", "--keep-saturated", "--uncertainty", "--phase",
                             "--modulation", "--mean", "--epipolar", "--motion-map"});

  command.common({"--output", "--mesh", "--depth", "--preview", "--scanner", "--strategy",
                  "--steps", "--high", "--low", "--projector"});
  command.examples({"reconstruct scan -o cloud.ply --depth depth.tiff --preview preview.png",
                    "reconstruct frames --strategy dual-frequency --steps 3 --high 16 --low 1 "
                    "--axis x --projector 1824x1140 --scanner scanner.yaml -o cloud.ply",
                    "reconstruct phase.tiff --from phase:16 --scanner scanner.yaml -o cloud.ply"},
                   "Several scans: {name} in a path is replaced by the scan's name, e.g. -o "
                   "clouds/{name}.ply\nWhole recordings: slipstream reconstruct scan.slip "
                   "--windows : -o clouds/{name}-{window}.ply");
}

}  // namespace slipstream::app
