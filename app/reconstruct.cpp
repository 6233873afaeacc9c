#include "app/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <future>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/process.h"
#include "app/reconstructed_scan.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "decode/frame_motion.h"
#include "geometry/map_form.h"
#include "io/depth_truth.h"
#include "io/file.h"
#include "io/model_file.h"
#include "merge/model_surface.h"
#include "slipstream/scan_job.h"
#include "slipstream/surface.h"

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
  throw_if(two_cameras,
           "--uncertainty works with one camera and the projector; add --one-camera or --fuse");
  if (!setup.scanner.photometry.noise_variance) {
    output.warn(
        "noise variance unknown, 1.6 assumed for the uncertainty; measure it with slipstream "
        "calibrate noise, or give --noise-variance");
  }
}

/// Writes the cloud of several cameras, and its surface.
void write_model_files(const ResultFiles& files, FusedModel model,
                       const std::shared_ptr<const FramePose>& frame,
                       const std::vector<std::string>& remarks) {
  if (frame) move_to_frame(model, *frame);
  if (!files.cloud.empty()) write_model(files.cloud, model, remarks);
  if (!files.mesh.empty()) write_surface(files.mesh, surface_of(mesh_of(model)));
}

/// Writes the cloud with normals and uncertainty on the requested grid; maps and preview on the
/// camera's.
void write_files(const ReconstructFlags& flags, const ReconstructedScan& scan) {
  const ScanResult& result = scan.result;

  ResultFiles maps = scan.files;
  maps.cloud.clear();
  const std::shared_ptr<const FramePose>& frame = wanted_frame(flags.job.reconstruct);
  if (result.fused) maps.mesh.clear();
  write_results(maps, result.cloud, result.maps, {.frame = frame});
  const std::vector<std::string> remarks = remarks_about(result.checked.findings);
  if (result.fused) return write_model_files(scan.files, *result.fused, frame, remarks);

  // The points that remain on a coarser grid.
  std::optional<Normals> normals;
  if (flags.normals && !scan.files.cloud.empty()) normals = smoothed_normals(result.cloud);
  std::optional<Uncertainty> uncertainty = result.uncertainty;
  const auto thin = [&](auto&... images) { ((images = subsampled(images, flags.subsample)), ...); };
  if (normals) thin(normals->x, normals->y, normals->z);
  if (uncertainty) {
    thin(uncertainty->coordinate, uncertainty->x, uncertainty->y, uncertainty->z,
         uncertainty->z_of_noise, uncertainty->z_systematic);
  }

  std::optional<Cloud> coarse;
  if (flags.subsample > 1) coarse = subsampled(result.cloud, flags.subsample);

  write_results({.cloud = scan.files.cloud}, coarse ? *coarse : result.cloud, {},
                {.normals = normals ? &*normals : nullptr,
                 .uncertainty = uncertainty ? &*uncertainty : nullptr,
                 .remarks = remarks,
                 .frame = frame});
}

/// Median depth of the points, mm, from 40,000 pixels; without points as the check found it, which
/// knows far fewer.
double median_depth_of(const ScanResult& result) {
  const Image<float>& z = result.cloud.z;
  const std::size_t step = z.pixel_count() / 40'000 + 1;
  std::vector<double> depths;
  for (std::size_t i = 0; i < z.pixel_count(); i += step) {
    if (std::isfinite(z.begin()[i])) depths.push_back(z.begin()[i]);
  }
  return depths.empty() ? result.checked.median_depth : median(std::move(depths));
}

/// Warns of the findings after the first `printed` ones, and compares the points with the truth.
void judge(const ReconstructFlags& flags, std::size_t printed, ReconstructedScan& scan) {
  warn_of_findings(scan.result.checked.findings, printed, text_of(scan.name), scan.held);
  scan.files = files_of_scan(flags.files, scan.name);
  scan.median_depth = median_depth_of(scan.result);
  if (scan.output == ScanOutput::points) {
    scan.rms = error_against_truth(scan.name.path, scan.result.cloud);
  }
}

/// The RMS of depth that the noise of the frames predicts. Only the virtual scanner's scans, whose
/// error is known, are worth the time.
std::optional<PredictedRms> predicted_error(const FrameViews& frames, ScanJob& job,
                                            const ReconstructedScan& scan) {
  const ScanResult& result = scan.result;
  const bool has_engine =
      result.backend != "coordinates" && result.setup.scanner.photometry.noise_variance;
  if (!scan.rms || !has_engine) return std::nullopt;

  return predicted_rms(job.uncertainty_of(result, frames));
}

/// State passed from one scan to the next.
struct Reused {
  std::map<ScanOutput, ScanJob> jobs;  ///< one for each kind of result
  bool fallback_printed = false;
  bool unguarded_printed = false;

  ScanJob& job_of(ScanOutput output, const ReconstructFlags& flags) {
    ScanJobSettings settings = flags.job;
    settings.output = output;
    return jobs.try_emplace(output, settings).first->second;
  }
};

/// Says once that nothing shows whether the rig has moved.
void tell_unguarded(const ReconstructedScan& scan, const Scan& taken, Reused& reused,
                    Output& output) {
  const bool is_unguarded = scan.output == ScanOutput::points && taken.scanner &&
                            taken.further_cameras.empty() && taken.other_axis.empty() &&
                            taken.guard.empty();
  if (!is_unguarded || std::exchange(reused.unguarded_printed, true)) return;
  output.say("{}: no guard: a camera or projector that moved since calibration would not show",
             text_of(scan.name));
}

/// Refuses what these flags ask of this scan and it cannot give.
void require_possible(const ReconstructFlags& flags, const LoadedScan& loaded, bool two_cameras,
                      Output& output) {
  const CheckedJob& job = loaded.job;
  const bool has_other_axis = !job.scan.other_axis.empty();
  throw_if(job.fuses && flags.subsample > 1,
           "--subsample needs one camera; the points of several have no rows and columns");
  if (flags.job.uncertainty || job.fuses) {
    const bool matches = two_cameras && job.scan.scanner && !job.fuses;
    require_uncertainty_possible(job.setup, matches, output);
  }
  throw_if(!flags.files.epipolar.empty() && (two_cameras || !has_other_axis),
           "--epipolar needs one camera and patterns along both axes: --axis both");

  const Band& band = measuring_band(job.setup.sequence.strategy.layout());
  throw_if(!flags.files.motion.empty() && (two_cameras || !MotionMeasurement::is_possible(band)),
           "--motion-map needs one camera and extra frames: --motion 2");

  throw_if(!flags.files.reflection.empty() && !rejects_reflection(job.setup.settings.clean),
           "--reflection-map needs --reflection or --local-reflection");

  throw_if(job.setup.settings.correct_contrast && loaded.scan.output == ScanOutput::maps,
           "--correct-contrast moves points, which need a scanner");
}

void reconstruct_scan(LoadedScan& loaded, const ReconstructFlags& flags, Reused& reused) {
  const CheckedJob& checked = loaded.job;
  ReconstructedScan& scan = loaded.scan;
  const std::string name = text_of(scan.name);
  Output& output = scan.held;
  const bool two_cameras =
      !checked.scan.further_cameras.empty() && scan.output == ScanOutput::points;
  require_possible(flags, loaded, two_cameras, output);

  // 1. The results, and what there is to say of them.
  ScanJob& job = reused.job_of(scan.output, flags);
  scan.result = job(checked, name);
  const ScanResult& result = scan.result;

  const double minimum = flags.job.reconstruct.minimum_modulation;
  if (result.least_modulation > minimum) {
    output.say(
        "{}: minimum modulation is {:.1f} instead of {:.1f}: below it noise hides the fringe order",
        name, result.least_modulation, minimum);
  }
  const bool depends_on_gamma = !two_cameras || !checked.fuses;  // what its sentence says
  if (depends_on_gamma && !result.gamma.sentence.empty()) {
    output.say("{}: {}", name, result.gamma.sentence);
  }
  if (!two_cameras && !reused.fallback_printed) {
    const bool chosen = result.setup.settings.engine != EngineKind::automatic;
    reused.fallback_printed = tell_fallback(result.fallback_reason, chosen, output);
  }

  if (!checked.fuses) tell_unguarded(scan, checked.scan, reused, output);

  // 2. Files, the other cameras, and the error of a virtual scan against its truth.
  judge(flags, checked.checked.findings.size(), scan);
  if (!two_cameras) scan.predicted = predicted_error(checked.scan.frames, job, scan);
  if (result.uncertainty) scan.median_sigma = median_depth(*result.uncertainty);
}

void reconstruct_map_file(LoadedScan& loaded, const ReconstructFlags& flags) {
  ReconstructedScan& scan = loaded.scan;
  const std::size_t printed = loaded.job.checked.findings.size();
  throw_if(rejects_reflection(loaded.job.setup.settings.clean),
           "--reflection and --local-reflection need frames, not a map");
  throw_if(loaded.job.setup.settings.correct_contrast && !flags.modulation,
           "with --from, --correct-contrast needs --from-modulation");

  scan.result =
      reconstruct_map(loaded.coordinates, loaded.job.setup, loaded.modulation, loaded.job.checked);
  if (!flags.job.keep_refused) require_right(scan.result.checked, text_of(scan.name), printed);
  judge(flags, printed, scan);
}

ReconstructedScan reconstructed(LoadedScan loaded, const ReconstructFlags& flags, Reused& reused) {
  ReconstructedScan& scan = loaded.scan;
  if (scan.done_before || !scan.failure.empty()) return std::move(scan);

  try {
    if (flags.from.empty()) {
      reconstruct_scan(loaded, flags, reused);
    } else {
      reconstruct_map_file(loaded, flags);
    }
  } catch (const RefusedScan& refused) {
    scan.held.document["findings"] = refused.findings();
    scan.failure = with_flags(refused.what());
  } catch (const Error& error) {
    scan.failure = with_flags(error.what());
  }
  return std::move(scan);
}

ReconstructedScan written(ReconstructedScan scan, const ReconstructFlags& flags) {
  if (scan.done_before || !scan.failure.empty()) return scan;

  Stopwatch watch;
  write_files(flags, scan);
  if (!flags.manifest.empty()) scan.entry["outputs"] = sums_of(scan.files.written());
  scan.written = watch.lap();

  scan.result.maps = {};
  scan.result.uncertainty.reset();
  return scan;
}

/// A failure ends the program if it is the only scan.
void tell(const ReconstructedScan& scan, bool only_one, Output& output) {
  output.release(scan.held);

  if (scan.failure.empty()) {
    if (output.is_json()) output.list("scans").push_back(document_of(scan));
    return tell(scan, output);
  }

  if (only_one) {
    output.document.update(scan.held.document);  // the diagnostics that refused it
    throw Error(scan.failure);
  }

  // One of several scans: the others go on, and the exit code says that one has failed.
  nlohmann::json failed = described("scan", text_of(scan.name), "error", scan.failure);
  failed.update(scan.held.document);
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
    if (scan.done_before) {
      ++done_before;
    } else {
      tell(scan, count == 1, output);
    }
    const auto job = reused.jobs.find(scan.output);
    if (job != reused.jobs.end()) job->second.reuse(std::move(scan.result.cloud));
    progress.advance(scan.done_before);
  };

  // Three stages overlap: scan i is reconstructed, later ones are read, earlier ones written.
  for (std::size_t i = 0, started = 0; i < count; ++i) {
    for (; started < std::min(i + threads, count); ++started) {
      loading.push_back(std::async(start, [&flags, &output, &opened, log,
                                           &name = flags.scans[started]] {
        return loaded_scan(name, flags, log != nullptr ? &log->before : nullptr, opened, output);
      }));
    }

    // This thread reconstructs; the task only writes the files. With several scans the bar shows
    // how far the work is.
    const auto tell_stage = [&](const char* work) {
      if (count == 1) output.tell_wait(fmt::format("{}: {}", flags.scans[i].path, work));
    };
    tell_stage("reading");
    LoadedScan loaded = next_of(loading);
    tell_stage("reconstructing");
    ReconstructedScan scan = reconstructed(std::move(loaded), flags, reused);
    tell_stage("writing");
    writing.push_back(std::async(start, [&flags, scan = std::move(scan)]() mutable {
      return written(std::move(scan), flags);
    }));

    while (writing.size() > most_written) tell_next();
  }

  while (!writing.empty()) tell_next();
  if (log == nullptr) return;
  output.document["done_before"] = done_before;
  if (done_before > 0) output.say("{} of {} scans were already done", done_before, count);
}

void reconstruct(const ReconstructFlags& parsed, Output& output) {
  ReconstructFlags flags = parsed;
  flags.scans = scan_names(listed_scans(flags), flags.every);
  flags.settings = arguments_of(*flags.command, Arguments::settings);
  reconstruct_scans(std::move(flags), output);
}

}  // namespace

void reconstruct_scans(ReconstructFlags flags, Output& output) {
  require_writable(flags.files, flags.scans);
  require_valid(flags);
  flags.job.maps = flags.files.any_map();
  flags.job.sure_coordinates = !flags.files.coordinate.empty();
  keep_memory();

  output.document["scans"] = nlohmann::json::array();
  throw_if(!flags.resume && !flags.manifest.empty() && fs::exists(flags.manifest),
           "{}: already exists; use --resume to continue it", flags.manifest);
  throw_if(!flags.manifest.empty() && flags.files.cloud == standard_output,
           "-o -: --manifest lists files; name one, e.g. {{name}}.ply");

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
  command.add_output("--manifest", flags.manifest,
                     "log of finished scans, one JSON line each: .jsonl");
  command
      .add("--resume", flags.resume,
           "skip scans that the manifest lists as done with the same input, settings and outputs")
      ->needs("--manifest");

  add_reconstruct_flags(command.app, flags);

  // Maps of another program replace the frames, so flags about frames do not apply.
  command.add("--from", flags.from,
              fmt::format("read maps of another program, .tiff or .npy, NaN where invalid, instead "
                          "of scans: {}; --origin is the value at the edge of the field, and "
                          "--backwards says that values fall across it",
                          map_forms));
  command
      .add_file(
          "--from-modulation", flags.modulation,
          "with --from: the map's modulation, grey levels of 255, for --minimum-modulation and "
          "cleaning")
      ->needs("--from");

  command.exclude(
      "--from", {"--windows",   "--strategy",    "--steps",   "--high",           "--low",
                 "--frequency", "--periods",     "--order",   "--exposures",      "--motion",
                 "--gamma",     "--camera-bits", "--channel", "--keep-saturated", "--uncertainty",
                 "--phase",     "--modulation",  "--mean",    "--epipolar",       "--motion-map"});

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
