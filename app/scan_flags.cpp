#include "app/scan_flags.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/numbers.h"
#include "io/pose_file.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/strategy.h"
#include "slipstream/unwrapping.h"

namespace slipstream::app {
namespace {

std::vector<double> settings_in(const std::string& text) {
  std::vector<double> numbers;
  SettingValue(text).read(numbers);
  return numbers;
}

/// Why a non-numeric setting is invalid; empty if it is valid.
std::string numbers_only(const std::string& text) try {
  settings_in(text);
  return {};
} catch (const Error& error) {
  return error.what();
}

/// The strategies, those that others replace at the end.
std::string strategies_in_help() {
  constexpr std::string_view rarely_used[] = {"two-plus-one",      "fast-three-step",
                                              "double-three-step", "two-frequency-2n",
                                              "two-frequency-4n",  "pcps"};

  std::vector<std::string_view> names = strategy_names();
  const auto older = std::stable_partition(names.begin(), names.end(), [&](auto name) {
    return std::ranges::find(rarely_used, name) == std::end(rarely_used);
  });

  return fmt::format("{}; less common: {}", fmt::join(names.begin(), older, ", "),
                     fmt::join(older, names.end(), ", "));
}

void add_sequence_flags(const FlagGroup& group, SequenceChanges& changes) {
  group.add("--strategy", changes.strategy, strategies_in_help());

  // A flag for each setting of the registry; switches have an opposite too.
  for (const SettingDescription& setting : strategy_settings()) {
    const std::string flag = flag_of(setting.name),
                      help = fmt::format("{} [{}]", with_flags(setting.help), setting.strategies);
    std::optional<std::string>& value = changes.settings[setting.name];

    if (setting.is_switch) {
      group.app.add_flag(fmt::format("{},!--no-{}", flag, flag.substr(2)), value, help)
          ->group(group.name);
    } else if (CLI::Option* const option = group.add(flag, value, help); !setting.is_word) {
      option->check(numbers_only);
    }
  }

  // Settings that do not belong to one strategy.
  group.add_read<>(
      "--period-pixels",
      [&changes](const std::string& text) { changes.period_pixels = settings_in(text); },
      "periods (also --frequency, --high and --low) as lengths in projector pixels");
  group.add("--stripe", changes.stripe_pixels,
            "--stripes as the width of a stripe in projector pixels");
  group.exclude("--period-pixels", {"--periods", "--frequency", "--high"});
  group.exclude("--stripe", {"--stripes"});

  group.add("--axis", changes.axes,
            "x: the pattern varies along projector columns; y: rows; both: first x, then y");
  group.add("--projector", changes.projector, "projector size in pixels, e.g. 1824x1140");

  group.add("--alpha-p", changes.alpha_p, "amplitude of the patterns, grey levels of 255");
  group.add("--beta-p", changes.beta_p, "darkest grey level of the patterns");

  const auto expose = [&changes](const std::string& text) {
    changes.exposures = numbers_in<double>(text, ',');
    throw_if(changes.exposures->empty(),
             "--exposures '{}': expected comma-separated numbers, e.g. 1,4,16", text);
  };
  group.add_read<>(
      "--exposures", expose,
      "repeat all patterns for each exposure and merge them, e.g. 1,4,16: relative, or in ms");

  group.add("--motion", changes.motion,
            "extra frames per cloud for motion compensation: 0, 2 or 4");
}

}  // namespace

void add_pattern_flags(CLI::App& subcommand, SequenceChanges& changes, bool with_marker) {
  const FlagGroup group{subcommand, "Patterns"};
  add_sequence_flags(group, changes);

  group.add("--binary", changes.binary, "dither patterns to 1 bit, for DMD projectors");

  if (with_marker) {
    group.add("--marker", changes.marker,
              "end each cycle with a dark frame, so that a camera can start anywhere");
  }

  // The help shows the defaults of the usual sequence.
  const Sequence usual = default_sequence({1024, 1024}, {});
  subcommand.get_option("--strategy")->default_str(usual.strategy.name());
  subcommand.get_option("--axis")->default_str(std::string(name_of(usual.axis)));
  subcommand.get_option("--alpha-p")->default_str(fmt::format("{:g}", usual.light.alpha_p));
  subcommand.get_option("--beta-p")->default_str(fmt::format("{:g}", usual.light.beta_p));
}

void add_scan_flags(CLI::App& subcommand, ScanChanges& changes) {
  const FlagGroup group{subcommand, "Patterns (override the scan's own)"};
  add_sequence_flags(group, changes.sequence);
  group.add(
      "--order", changes.order,
      "frame index of each pattern, from 0, e.g. 2,0,1 or 0-17; or 'code,sinusoids' if the code "
      "comes first");

  const auto choose = [&changes](const std::string& name) {
    changes.channel = grey_channel_named(name);
  };
  FlagGroup{subcommand}.add_read<>(
      "--channel", choose,
      "grey levels of colour pictures: auto (the best), grey, red, green or blue");
  FlagGroup{subcommand}.add("--mosaic", changes.mosaic,
                            "raw pictures of a colour camera: the colours of the first two pixels, "
                            "RG, GR, GB or BG, or its pixel format, e.g. BayerRG8");
}

bool is_pattern_switch(const std::string& word) {
  return std::ranges::any_of(strategy_settings(), [&](const SettingDescription& setting) {
    return setting.is_switch && flag_of(setting.name) == word;
  });
}

void add_anyway_flag(CLI::App& subcommand, bool& anyway) {
  FlagGroup{subcommand}.add("--anyway", anyway,
                            "continue with a scan that the check refuses, and mark the results");
}

void add_grey_patch_flag(const FlagGroup& group, ScanChanges& changes) {
  group.add("--grey-patch", changes.grey_patch,
            "balance the colours by this part of the picture, which shows grey or white: "
            "width x height + x + y; default: the scanner's white balance");
}

void add_scan_input_flags(CLI::App& subcommand, ScanChanges& changes, ScanJobSettings& job) {
  const FlagGroup options{subcommand};
  options.add_settings(job.photometry);
  options.add("--gamma", job.gamma,
              "response correction: scanner (from its file, if present), blind (from the frames), "
              "none, or a gamma");
  add_input_flags(subcommand, changes);
}

void add_input_flags(CLI::App& subcommand, ScanChanges& changes) {
  const FlagGroup options{subcommand};
  options.add_file("--scanner", changes.scanner, "scanner file; default: the scan's own");
  options.add("--camera-bits", changes.bits,
              "bit depth of the camera, if below 16 in 16-bit files");
  add_grey_patch_flag(options, changes);
  options.add("--camera-region", changes.camera_region,
              "part of the calibrated picture that the frames show, width x height + x + y, "
              "if the camera's region was set or the pictures were cropped since; frames of "
              "a half or a third of that size are taken for binned ones");

  add_scan_flags(subcommand, changes);
}

void add_backend_flag(const FlagGroup& group, ReconstructSettings& settings) {
  const auto read = [&settings](const std::string& name) { set_backend(settings, name); };
  group.add_read<>("--backend", read, with_flags(backend_forms))->default_str("fused");
}

void add_clean_flags(CLI::App& subcommand, ReconstructSettings& settings) {
  const FlagGroup group{subcommand, "Cleaning"};
  const auto take_raw = [&settings] { keep_all_points(settings); };

  subcommand  // added first: flags of single filters then override it
      .add_flag_callback("--raw", take_raw, "keep all points; apply only filters given by flag")
      ->group(group.name);

  // The two settings that are neither numbers nor switches: a box in mm, and an outline in pixels.
  group.add_settings(settings.clean, [&group](const std::string& flag, const std::string& help,
                                              auto& value) {
    const auto read = [&value](const std::vector<double>& numbers) {
      const std::size_t count = numbers.size();

      if constexpr (std::is_same_v<decltype(value), std::optional<PointBox>&>) {
        throw_if(count != 6, "--box: expected 6 numbers in mm, got {}; e.g. -50,-50,600,50,50,800",
                 count);
        value.emplace();
        std::copy_n(numbers.begin(), 3, value->least.begin());
        std::copy_n(numbers.begin() + 3, 3, value->largest.begin());
      } else {
        throw_if(count % 2 != 0 || count == 2,
                 "--outline: expected column and row of two or more corners, got {} numbers; e.g. "
                 "100,80,500,400",
                 count);
        value.clear();
        for (std::size_t i = 0; i < count; i += 2) value.push_back({numbers[i], numbers[i + 1]});
      }
    };

    group.add_read<std::vector<double>>(flag, read, help)->delimiter(',');
  });

  subcommand.get_option("--smallest-component")->default_str("");  // its help names the default
}

void add_frame_flag(CLI::App& subcommand, ReconstructSettings& settings) {
  const auto read = [&settings](const std::string& file) {
    settings.clean.box_frame = std::make_shared<const FramePose>(read_pose(file));
  };
  FlagGroup{subcommand}
      .add_read<>("--to-frame", read,
                  "pose file: clouds are written and shown in its frame, and --box is in it")
      ->type_name(file_type);
}

void add_cloud_flags(CLI::App& subcommand, ScanChanges& changes, ScanJobSettings& job) {
  add_anyway_flag(subcommand, job.keep_refused);
  FlagGroup{subcommand, "Valid pixels"}.add_settings(job.reconstruct);
  add_clean_flags(subcommand, job.reconstruct);
  add_frame_flag(subcommand, job.reconstruct);
  add_scan_input_flags(subcommand, changes, job);
}

void FlagsOfScans::refuse_for_cloud(const std::string& path) const {
  const CLI::Option* const rig = command->get_option_no_throw("--rig");
  if (rig != nullptr && rig->count() > 0) return;
  for (const CLI::Option* option : options) {
    throw_if(option->count() > 0, "{}: {} applies to scans only", path, option->get_name());
  }
}

FlagsOfScans flags_of_scans(const CLI::App& command, std::size_t before,
                            const std::set<std::string>& of_clouds) {
  FlagsOfScans flags{.command = &command};
  const std::vector<const CLI::Option*> all = command.get_options();
  std::copy_if(all.begin() + static_cast<std::ptrdiff_t>(before), all.end(),
               std::back_inserter(flags.options),
               [&](const CLI::Option* option) { return !of_clouds.contains(option->get_name()); });
  return flags;
}

std::shared_ptr<const RecordingReader> OpenedRecording::at(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (reader_ != nullptr && path == path_) return reader_;
  reader_ = is_recording(path) ? std::make_shared<const RecordingReader>(path) : nullptr;

  path_ = path;
  return reader_;
}

std::shared_ptr<const ListedFolder> OpenedRecording::folder_at(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (folder_ != nullptr && path == folder_path_) return folder_;
  folder_ = std::make_shared<const ListedFolder>(listed_folder(path));

  folder_path_ = path;
  return folder_;
}

Scan load_checkable(const std::string& path, const ScanChanges& changes, bool all_cameras,
                    Output& output) {
  Scan scan = all_cameras ? load_scan(path, changes) : load_scan(scan_files_in(path, changes));
  output.warn(scan.warnings);
  for (const Scan& further : scan.further_cameras) output.warn(further.warnings);
  return scan;
}

CheckedJob checked_scan(Scan scan, const std::string& name, const ScanJobSettings& settings,
                        Output& output) {
  CheckedJob job = checked_job(std::move(scan), settings, name);
  refuse_or_warn(job.checked, name, settings.keep_refused, output);
  return job;
}

ScanResult result_of(Scan scan, const std::string& name, const ScanJobSettings& settings,
                     Output& output) {
  const CheckedJob job = checked_scan(std::move(scan), name, settings, output);
  ScanResult result = ScanJob(settings)(job, name);

  const std::vector<Finding>& findings = result.checked.findings;
  nlohmann::json& listed = output.list("findings");  // also if there are none
  for (const Finding& finding : findings) listed.push_back(finding);
  warn_of_findings(findings, job.checked.findings.size(), name, output);
  return result;
}

void tell_guard(const EpipolarCheck& guard, const std::string& prefix, Output& output) {
  output.say(
      "{}guard: distance from epipolar lines common to all {} points {:.3f} projector pixels, of "
      "single points from that {:.3f}",
      prefix, guard.points, guard.common, guard.own);
}

StoredCloud loaded_cloud(const std::string& path, Output& output, double unit) {
  constexpr double harmless = 0.001;  // mm
  StoredCloud stored = read_cloud(path);
  const double rounding = unit * stored.rounding;
  if (rounding > harmless) {
    output.warn(
        fmt::format("{}: its coordinates are rounded to 32 bits, by up to {:.2g} mm; subtract a "
                    "common offset from them first",
                    path, rounding));
  }
  return stored;
}

void keep_box(Cloud& cloud, const CleanSettings& clean) {
  if (!clean.box) return;
  require_valid(clean);

  Eigen::Isometry3d to_box = Eigen::Isometry3d::Identity();
  if (clean.box_frame) to_box = pose_from_frame(*clean.box_frame, camera_frame).transform;
  if (cloud.frame) to_box = to_box * cloud.frame->transform.inverse();

  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    if (clean.box->contains(to_box * position_at(cloud, column, row))) return;
    cloud.reject(column, row, Validity::outside_region);
  });
}

StoredCloud organised_cloud(const std::string& path, const ScanChanges& changes,
                            ScanJobSettings job, Output& output) {
  StoredCloud result;

  // A cloud is taken as it is.
  if (is_cloud_file(path)) {
    result = loaded_cloud(path, output);
    throw_if(!result.organised,
             "{}: its points are not organised by pixel; measure the scan, or an organised .pcd",
             path);
    move_to_camera(result.cloud, result.uncertainty ? &*result.uncertainty : nullptr);
    return result;
  }

  // A scan is reconstructed from its first camera, with uncertainty if the noise is known; a code
  // has the width of its stripes instead.
  require_valid(job.reconstruct.clean);
  Scan scan = load_checkable(path, changes, false, output);
  job.uncertainty = job.photometry.noise_variance ||
                    (scan.scanner && scan.scanner->photometry.noise_variance) ||
                    scan.sequence.strategy.layout().unwrapping->whole_stripes;
  ScanResult made = result_of(std::move(scan), path, job, output);

  result.organised = true;
  result.cloud = std::move(made.cloud);
  result.uncertainty = std::move(made.uncertainty);
  return result;
}

}  // namespace slipstream::app
