#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/progress.h"
#include "app/scan_input.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/reconstruct/phase_matcher.h"
#include "slipstream/reconstruct/reconstructor.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// The files that one scan can be asked to give; empty where not asked.
struct OutputFiles {
  std::string cloud, depth, coordinate, phase, modulation, mean, preview;

  /// Every output with its name in the JSON document.
  [[nodiscard]] std::array<std::pair<const char*, std::string>, 7> all() const {
    return {{{"cloud", cloud},
             {"depth", depth},
             {"coordinate", coordinate},
             {"phase", phase},
             {"modulation", modulation},
             {"mean", mean},
             {"preview", preview}}};
  }
  /// What the cloud does not hold.
  [[nodiscard]] bool any_map() const {
    return !(coordinate.empty() && phase.empty() && modulation.empty() && mean.empty());
  }
};

struct ReconstructFlags {
  std::vector<std::string> folders;
  ScanInputFlags input;
  std::string backend = "fused";
  std::string unwrapping = "consensus";
  bool one_camera = false;
  PhaseMatchSettings match;
  ReconstructSettings settings;
  bool keep_saturated = false;
  bool normals = false;
  bool uncertainty = false;
  OutputFiles files;
};

class Stopwatch {
 public:
  /// Seconds since it was made or last asked.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Median of the standard deviations of depth, mm.
double median_depth_sigma(const Uncertainty& uncertainty) {
  std::vector<float> sigma;
  std::copy_if(uncertainty.z.begin(), uncertainty.z.end(), std::back_inserter(sigma),
               [](float value) { return std::isfinite(value); });
  if (sigma.empty()) return 0;
  const auto middle = sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2);
  std::nth_element(sigma.begin(), middle, sigma.end());
  return *middle;
}

/// A cloud and the backend that decoded it.
struct ReconstructedBy {
  Reconstruction result;
  std::string backend;
};

/// Of a scan with two cameras, by matching their phases.
ReconstructedBy match_cameras(const ScanDescription& scan, const Scanner& scanner,
                              const FrameSet& frames, ReconstructFlags flags, Output& output) {
  flags.input.scanner.reset();
  const ScanDescription second = describe(*scan.second_camera, flags.input);
  if (name_of(second.strategy) != name_of(scan.strategy) ||
      settings_of(second.strategy) != settings_of(scan.strategy) || second.axis != scan.axis) {
    throw Error(fmt::format("{}: another strategy than the first camera's; both see one projector",
                            scan.second_camera->string()));
  }
  const LoadedFrames loaded = read_frames(second.frames, second.bits);
  for (const std::string& warning : loaded.warnings) output.warn(warning);
  const PhaseMatcher match(scanner, scanner_for(second, loaded.frames.size()), scan.strategy,
                           scan.axis, flags.settings, flags.match);
  return {match(frames, loaded.frames), match.backend_for(frames)};
}

/// With several scans "{name}" in an output's path stands for the scan's folder.
std::string for_scan(const std::string& path, const fs::path& folder) {
  static constexpr std::string_view placeholder = "{name}";
  std::string filled = path;
  const std::string name = fs::absolute(folder / "").parent_path().filename().string();
  for (std::size_t at = filled.find(placeholder); at != std::string::npos;
       at = filled.find(placeholder, at + name.size())) {
    filled.replace(at, placeholder.size(), name);
  }
  return filled;
}

void require_good_paths(const ReconstructFlags& flags) {
  if (!flags.files.cloud.empty()) require_cloud_ending(flags.files.cloud);
  for (const auto& [name, path] : flags.files.all()) {
    if (flags.folders.size() > 1 && !path.empty() && path.find("{name}") == std::string::npos) {
      throw Error(
          fmt::format("{}: several scans cannot all be written to it; put {{name}} in its "
                      "path, which stands for each scan's folder",
                      path));
    }
  }
}

/// What was written, by its name in the JSON document.
nlohmann::json write_outputs(const ReconstructFlags& flags, const fs::path& folder,
                             const Reconstruction& result,
                             const std::optional<Uncertainty>& uncertainty) {
  nlohmann::json written = nlohmann::json::object();
  const auto write = [&](const char* name, const std::string& asked, const auto& writer) {
    if (asked.empty()) return;
    const std::string path = for_scan(asked, folder);
    writer(path);
    written[name] = path;
  };
  const auto write_as_map = [&](const char* name, const std::string& asked,
                                const Image<double>& map) {
    write(name, asked, [&](const std::string& path) { write_map(path, map); });
  };
  write("cloud", flags.files.cloud, [&](const std::string& path) {
    const std::optional<Normals> normals =
        flags.normals ? std::optional(surface_normals(result.cloud)) : std::nullopt;
    write_cloud(path, result.cloud,
                {.normals = normals ? &*normals : nullptr,
                 .uncertainty = uncertainty ? &*uncertainty : nullptr});
  });
  write_as_map("depth", flags.files.depth, result.cloud.z);
  write_as_map("coordinate", flags.files.coordinate, result.decoded.coordinate);
  write_as_map("phase", flags.files.phase, result.decoded.wrapped_phase);
  write_as_map("modulation", flags.files.modulation, result.decoded.modulation);
  write_as_map("mean", flags.files.mean, result.decoded.mean);
  write("preview", flags.files.preview,
        [&](const std::string& path) { write_depth_preview(path, result.cloud); });
  return written;
}

/// RMS of depth minus truth over the points that have both, mm.
std::optional<double> error_against_truth(const fs::path& folder, const Cloud& cloud) {
  const fs::path file = folder / "truth" / "depth.tiff";
  if (!fs::exists(file)) return std::nullopt;
  const Image<double> truth = read_map(file);
  if (truth.size() != cloud.size()) {
    throw Error(fmt::format("{} is {}, the frames are {}; both must agree", file.string(),
                            text_of(truth.size()), text_of(cloud.size())));
  }
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
    const double difference = cloud.z.begin()[i] - truth.begin()[i];
    if (!std::isfinite(difference)) continue;
    sum += difference * difference;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

nlohmann::json counts_of(const Cloud& cloud) {
  nlohmann::json counts;
  const auto by_validity = count_by_validity(cloud);
  for (std::size_t i = 0; i < validity_count; ++i) {
    counts[std::string(name_of(static_cast<Validity>(i)))] = by_validity[i];
  }
  return counts;
}

/// Keeps the tables from one scan to the next as long as scanner, strategy and axis stay the same.
class ReconstructorOfScans {
 public:
  explicit ReconstructorOfScans(const ReconstructSettings& settings) : settings_(settings) {}

  const Reconstructor& for_scan(const ScanDescription& scan, const Scanner& scanner,
                                const GammaChoice& gamma,
                                const PhotometricCalibration& photometry) {
    const std::string wanted =
        fmt::format("{} {} {} {} {} {} {} {} {} {} {}", scan.scanner->string(),
                    nlohmann::json(settings_of(scan.strategy)).dump(), name_of(scan.strategy),
                    name_of(scan.axis), text_of(scanner.camera.size), text_of(scan.projector),
                    json_of(gamma).dump(), scan.light.alpha_p, scan.light.beta_p,
                    photometry.ambient.value_or(0), photometry.noise_variance.value_or(0));
    if (wanted != made_for_) {
      reconstructor_.emplace(scanner, scan.strategy, scan.axis,
                             settings_for(settings_, scan, gamma, photometry));
      made_for_ = wanted;
    }
    return *reconstructor_;
  }

 private:
  ReconstructSettings settings_;
  std::string made_for_;
  std::optional<Reconstructor> reconstructor_;
};

void tell(const nlohmann::json& scan, Output& output) {
  output.say("{}: {} points of {} pixels, backend {}", scan["scan"].get<std::string>(),
             scan["points"].get<std::size_t>(), scan["pixels"].get<std::size_t>(),
             scan["backend"].get<std::string>());
  for (const auto& [reason, count] : scan["counts"].items()) {
    if (reason != "valid" && count != 0) output.say("  left out, {}: {}", reason, count.dump());
  }
  if (scan.contains("rms_mm")) {
    output.say("  RMS error against truth: {:.4g} mm", scan["rms_mm"].get<double>());
  }
  if (scan.contains("median_sigma_z_mm")) {
    output.say("  uncertainty of depth: median sigma {:.4g} mm",
               scan["median_sigma_z_mm"].get<double>());
  }
  const auto& seconds = scan["seconds"];
  const auto ms = [&](const char* lap) { return 1e3 * seconds[lap].get<double>(); };
  output.say(
      "  time: {:.0f} ms to read, {:.0f} for gamma, {:.0f} for tables, {:.0f} to reconstruct, "
      "{:.0f} to write",
      ms("read"), ms("gamma"), ms("tables"), ms("reconstruct"), ms("write"));
  for (const auto& [name, path] : scan["files"].items()) {
    output.say("  {}: {}", name, path.get<std::string>());
  }
}

nlohmann::json reconstruct_scan(const fs::path& folder, const ReconstructFlags& flags,
                                ReconstructorOfScans& reconstructors, Output& output) {
  Stopwatch watch;
  const ScanDescription scan = describe(folder, flags.input);
  const LoadedFrames loaded = read_frames(scan.frames, scan.bits);
  for (const std::string& warning : loaded.warnings) output.warn(warning);
  const Scanner scanner = scanner_for(scan, loaded.frames.size());
  const PhotometricCalibration photometry = photometry_for(scan, flags.input);
  const double read = watch.lap();
  const bool two_cameras = scan.second_camera && !flags.one_camera;
  const GammaChoice gamma =
      two_cameras ? GammaChoice{.source = "two cameras", .sentence = "two cameras, free of gamma"}
                  : choose_gamma(flags.input.gamma, scan, loaded.frames);
  const double choosing = watch.lap();
  if (two_cameras && flags.uncertainty) {
    throw Error("--uncertainty is of one camera and the projector; add --one-camera");
  }
  if (flags.uncertainty && !photometry.noise_variance) {
    throw Error(
        fmt::format("{}: no noise variance in it, which --uncertainty needs; measure it "
                    "with slipstream calibrate noise, or give --noise-variance",
                    scan.scanner->string()));
  }
  const Reconstructor& reconstruct = reconstructors.for_scan(scan, scanner, gamma, photometry);
  const double tables = watch.lap();
  if (!gamma.sentence.empty()) output.say("{}: {}", folder.string(), gamma.sentence);
  const auto reconstructed = [&]() -> ReconstructedBy {
    if (two_cameras) return match_cameras(scan, scanner, loaded.frames, flags, output);
    const std::string backend = reconstruct.backend_for(loaded.frames);
    if (flags.files.any_map() || flags.uncertainty) return {reconstruct(loaded.frames), backend};
    return {{reconstruct.cloud(loaded.frames), {}}, backend};
  };
  const auto [result, backend] = reconstructed();
  const double computed = watch.lap();
  const std::optional<Uncertainty> uncertainty =
      flags.uncertainty ? std::optional(reconstruct.uncertainty(result, loaded.frames))
                        : std::nullopt;
  nlohmann::json files = write_outputs(flags, folder, result, uncertainty);

  nlohmann::json told = {{"scan", folder.string()},
                         {"points", point_count(result.cloud)},
                         {"pixels", result.cloud.z.pixel_count()},
                         {"counts", counts_of(result.cloud)},
                         {"backend", backend},
                         {"gamma", json_of(gamma)},
                         {"files", std::move(files)},
                         {"warnings", loaded.warnings},
                         {"seconds",
                          {{"read", read},
                           {"gamma", choosing},
                           {"tables", tables},
                           {"reconstruct", computed},
                           {"write", watch.lap()}}}};
  if (uncertainty) told["median_sigma_z_mm"] = median_depth_sigma(*uncertainty);
  if (const auto rms = error_against_truth(folder, result.cloud)) told["rms_mm"] = *rms;
  return told;
}

void reconstruct(ReconstructFlags flags, Output& output) {
  require_good_paths(flags);
  flags.settings.backend = backend_named(flags.backend);
  flags.settings.cue.unwrapping = unwrapping_named(flags.unwrapping);
  flags.settings.drop_saturated = !flags.keep_saturated;
  ReconstructorOfScans reconstructors(flags.settings);
  output.document["scans"] = nlohmann::json::array();

  Progress progress("scans", static_cast<int>(flags.folders.size()));
  for (const std::string& folder : flags.folders) {
    output.document["scans"].push_back(reconstruct_scan(folder, flags, reconstructors, output));
    progress.advance();
  }
  progress.finish();
  for (const nlohmann::json& scan : output.document["scans"]) tell(scan, output);
  const auto files = flags.files.all();
  if (std::all_of(files.begin(), files.end(),
                  [](const auto& file) { return file.second.empty(); })) {
    output.say("nothing was asked to be written; -o cloud.ply writes the cloud");
  }
}

void add_output_flags(CLI::App& command, ReconstructFlags& flags) {
  const std::string group = "What to write";
  OutputFiles& files = flags.files;
  command.add_option("-o,--output", files.cloud, "the cloud: .ply, .pcd or .xyz")->group(group);
  command.add_option("--depth", files.depth, "depth map, mm: .tiff")->group(group);
  command.add_option("--coordinate", files.coordinate, "projector coordinate, 0 to 1: .tiff")
      ->group(group);
  command.add_option("--phase", files.phase, "wrapped phase, rad: .tiff")->group(group);
  command.add_option("--modulation", files.modulation, "modulation B, grey levels: .tiff")
      ->group(group);
  command.add_option("--mean", files.mean, "mean A, grey levels: .tiff")->group(group);
  command.add_option("--preview", files.preview, "depth as a coloured picture with a scale: .png")
      ->group(group);
  command.add_flag("--normals", flags.normals, "surface normals into the cloud")->group(group);
  command
      .add_flag("--uncertainty", flags.uncertainty,
                "standard deviation of each point, by the frames' noise, into the cloud")
      ->group(group);
}

void add_point_flags(CLI::App& command, ReconstructFlags& flags) {
  const std::string group = "Which pixels become points";
  ReconstructSettings& settings = flags.settings;
  command
      .add_option("--min-modulation", settings.minimum_modulation,
                  "least modulation, grey levels of the frames; 15 of 255 where not given")
      ->group(group);
  command.add_flag("--keep-saturated", flags.keep_saturated, "keep pixels with a saturated frame")
      ->group(group);
  command.add_option("--nearest", settings.nearest, "least depth, mm")
      ->capture_default_str()
      ->group(group);
  command.add_option("--farthest", settings.farthest, "largest depth, mm")->group(group);
}

}  // namespace

void add_reconstruct(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("reconstruct", "scan folder(s) to cloud, depth, phase, preview");
  const auto flags = std::make_shared<ReconstructFlags>();
  command->add_option("folders", flags->folders, "scan folders: pictures, and scan.yaml or flags")
      ->required();
  command->add_option("--backend", flags->backend, "fused, lut, closed-form or equation")
      ->capture_default_str();
  command
      ->add_option("--unwrapping", flags->unwrapping,
                   "fringe order from a cue in the same frames: consensus, likelihood or published")
      ->capture_default_str();
  command->add_flag("--one-camera", flags->one_camera,
                    "use the first camera alone where the scan has two");
  command
      ->add_option("--match-window", flags->match.window,
                   "two cameras: half the width of the window whose plane gives the depth, pixels")
      ->capture_default_str();
  add_output_flags(*command, *flags);
  add_point_flags(*command, *flags);
  add_scan_input_flags(*command, flags->input);
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream reconstruct scan -o cloud.ply --depth depth.tiff --preview "
      "preview.png\n  slipstream reconstruct frames --strategy dual-frequency --steps 3 --high 16 "
      "--low 1 --axis x --projector 1824x1140 --scanner scanner.yaml -o cloud.ply\nSeveral scans: "
      "{name} in a path stands for each scan's folder, as in -o clouds/{name}.ply");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { reconstruct(*flags, output); }; });
}

}  // namespace slipstream::app
