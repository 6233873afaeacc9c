#include "app/scan_input.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "app/process.h"
#include "slipstream/base/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace {

void set_box(std::optional<PointBox>& box, const std::vector<double>& numbers) {
  if (numbers.size() != 6) {
    throw Error(
        fmt::format("--box takes 6 numbers, mm, not {}: -50,-50,600,50,50,800", numbers.size()));
  }
  box.emplace();
  std::copy_n(numbers.begin(), 3, box->least.begin());
  std::copy_n(numbers.begin() + 3, 3, box->largest.begin());
}

void set_outline(std::vector<PictureCorner>& outline, const std::vector<double>& numbers) {
  if (numbers.size() % 2 != 0 || numbers.size() == 2) {
    throw Error(fmt::format(
        "--outline takes column and row of two corners or more, not {} numbers: 100,80,500,400",
        numbers.size()));
  }
  outline.clear();
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    outline.push_back({numbers[i], numbers[i + 1]});
  }
}

/// Puts into the scan the response that its phases are corrected for, both in the check and in the
/// cloud. Two cameras under one projector match whatever phase it shows.
GammaChoice gamma_of(Scan& scan, const ScanInputFlags& flags) {
  GammaChoice choice = choose_response(scan, flags.gamma);
  if (scan.further_cameras.empty()) return choice;
  return {.source = "two cameras", .sentence = "two cameras, free of gamma"};
}

StoredCloud cloud_of_scan(const std::string& path, const CloudInputFlags& flags, Output& output) {
  require_valid(flags.settings.clean);
  Scan scan = load(path, flags.input, false, output);
  const SoundScan sound = sound_scan(scan, path, flags, output);
  nlohmann::json& findings = output.list("findings");
  for (const auto& finding : app::json_of(sound.checked.findings)) findings.push_back(finding);
  Engine engine(sound.setup);
  StoredCloud result;
  result.organised = true;
  Maps maps;
  engine.cloud_and_maps(scan.frames, result.cloud, maps);
  if (engine.setup().scanner.photometry.noise_variance) {
    result.uncertainty = engine.uncertainty(result.cloud, maps, scan.frames);
  }
  return result;
}

}  // namespace

void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags) {
  const FlagGroup options{subcommand};
  options.add_file("--scanner", flags.changes.scanner, "scanner file; where not that of the scan");
  options.add("--ambient", flags.photometry.ambient,
              "ambient light, grey levels of 255, where not that of the scanner file");
  options.add("--noise-variance", flags.photometry.noise_variance,
              "sigma_w^2, grey levels^2 of 255, where not that of the scanner file");
  options.add("--gamma", flags.gamma,
              "the response the phase is corrected for: scanner (as its file says, if it does), "
              "blind (from the frames), none, or a number");
  options.add("--camera-bits", flags.changes.bits, "of the camera, where 16-bit files hold fewer");
  add_scan_flags(subcommand, flags.changes);
}

void add_backend_flag(const FlagGroup& group, ReconstructSettings& settings) {
  const auto read = [&settings](const std::string& name) { set_backend(settings, name); };
  group.add_read<>("--backend", read, backend_forms)->default_str("fused");
}

void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings) {
  FlagGroup{subcommand, "Which pixels become points"}.add_settings(settings,
                                                                   [](const Setting&, auto&) {});
}

void add_clean_flags(CLI::App& subcommand, ReconstructSettings& settings) {
  const FlagGroup group{subcommand, "Which points stay, and how"};
  const auto take_raw = [&settings] {
    settings.clean = CleanSettings::none();
    settings.nearest = settings.nearest.value_or(0);
    settings.farthest = settings.farthest.value_or(std::numeric_limits<double>::infinity());
  };
  subcommand  // first, so that flags set what it has cleared
      .add_flag_callback("--raw", take_raw, "leave all points in: no filter but those asked for")
      ->group(group.name);
  group.add_settings(settings.clean, [&group](const Setting& setting, auto& value) {
    const auto read = [&value](const std::vector<double>& numbers) {
      if constexpr (std::is_same_v<decltype(value), std::optional<PointBox>&>) {
        set_box(value, numbers);
      } else {
        set_outline(value, numbers);
      }
    };
    group.add_read<std::vector<double>>(setting.flag, read, setting.help)->delimiter(',');
  });
  subcommand.get_option("--min-component")->default_str("");  // its help says it
}

void add_cloud_input_flags(CLI::App& subcommand, CloudInputFlags& flags) {
  add_anyway_flag(subcommand, flags.anyway);
  add_point_flags(subcommand, flags.settings);
  add_clean_flags(subcommand, flags.settings);
  add_scan_input_flags(subcommand, flags.input);
}

std::shared_ptr<const RecordingReader> OpenedRecording::at(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (reader_ != nullptr && path == path_) return reader_;
  reader_ = is_recording(path) ? std::make_shared<const RecordingReader>(path) : nullptr;
  path_ = path;
  return reader_;
}

Scan load_checkable(const std::string& path, const ScanInputFlags& flags, bool all_cameras,
                    Output& output) {
  Scan scan =
      all_cameras ? load_scan(path, flags.changes) : load_scan(scan_files_in(path, flags.changes));
  if (scan.scanner) {
    PhotometricCalibration& known = scan.scanner->photometry;
    if (flags.photometry.ambient) known.ambient = flags.photometry.ambient;
    if (flags.photometry.noise_variance) known.noise_variance = flags.photometry.noise_variance;
  }
  for (const std::string& warning : scan.warnings) output.warn(warning);
  for (const Scan& further : scan.further_cameras) {
    for (const std::string& warning : further.warnings) output.warn(warning);
  }
  return scan;
}

Scan load(const std::string& path, const ScanInputFlags& flags, bool all_cameras, Output& output) {
  Scan scan = load_checkable(path, flags, all_cameras, output);
  if (scan.scanner) return scan;
  throw Error(fmt::format(
      "{}: no scanner is known for it; name its file with --scanner or in scan.yaml", path));
}

SoundScan sound_scan(Scan& scan, const std::string& name, const CloudInputFlags& flags,
                     Output& output) {
  Stopwatch watch;
  SoundScan sound;
  sound.gamma = gamma_of(scan, flags.input);
  sound.setup = setup_for(scan, flags.settings);
  sound.choosing = watch.lap();
  scan.further_cameras.empty() ? require_reconstructible(sound.setup) : require_valid(sound.setup);
  sound.checked = check_and_repair(scan, {.minimum_modulation = flags.settings.minimum_modulation});
  refuse_or_warn(sound.checked, name, flags.anyway, output);
  if (!sound.checked.repairs.empty()) sound.gamma = gamma_of(scan, flags.input);  // may be another
  sound.setup.scanner.photometry.response = sound.gamma.response;
  sound.checking = watch.lap();
  return sound;
}

StoredCloud organised_cloud(const std::string& path, const CloudInputFlags& flags, Output& output) {
  if (!is_cloud_file(path)) return cloud_of_scan(path, flags, output);
  StoredCloud stored = read_cloud(path);
  if (!stored.organised) {
    throw Error(
        fmt::format("{}: its points are not in the order of pixels, by which they are named; "
                    "measure the scan, or an organised .pcd",
                    path));
  }
  return stored;
}

}  // namespace slipstream::app
