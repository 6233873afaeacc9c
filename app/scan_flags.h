#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "app/commands.h"
#include "slipstream/cloud_file.h"
#include "slipstream/engine.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scan_job.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {

/// Adds --strategy, a flag per setting of the registry, --axis, --projector, --alpha-p, --beta-p,
/// --exposures, --motion and --binary; `with_marker` also --marker, for commands that show or see
/// repeated patterns. Switches also have an opposite: --no-backwards.
void add_pattern_flags(CLI::App& subcommand, SequenceChanges& changes, bool with_marker = false);

/// Adds the flags of add_pattern_flags except --binary, and --order; for commands that read scans.
void add_scan_flags(CLI::App& subcommand, ScanChanges& changes);

/// Whether the word is a switch of a pattern setting.
bool is_pattern_switch(const std::string& word);

/// Adds --scanner, --camera-bits, --camera-region, --grey-patch and the flags of add_scan_flags.
void add_input_flags(CLI::App& subcommand, ScanChanges& changes);

/// Adds the flags of add_input_flags, --gamma, --ambient-light and --noise-variance.
void add_scan_input_flags(CLI::App& subcommand, ScanChanges& changes, ScanJobSettings& job);

/// Adds --grey-patch.
void add_grey_patch_flag(const FlagGroup& group, ScanChanges& changes);

void add_anyway_flag(CLI::App& subcommand, bool& anyway);

void add_backend_flag(const FlagGroup& group, ReconstructSettings& settings);

/// Adds --raw, which also removes the limits of depth, and the flags of `settings.clean`.
void add_clean_flags(CLI::App& subcommand, ReconstructSettings& settings);

/// Adds --to-frame, in which clouds are written and shown, and the box is given. Call it after
/// add_clean_flags, whose --raw resets the box's frame.
void add_frame_flag(CLI::App& subcommand, ReconstructSettings& settings);

/// The pose of --to-frame; null: results stay in the camera's frame.
inline const std::shared_ptr<const FramePose>& wanted_frame(const ReconstructSettings& settings) {
  return settings.clean.box_frame;
}

/// Adds --anyway and the flags of points, cleaning and scans.
void add_cloud_flags(CLI::App& subcommand, ScanChanges& changes, ScanJobSettings& job);

/// Options of a command that apply to scans, and would be ignored for clouds.
struct FlagsOfScans {
  const CLI::App* command = nullptr;
  std::vector<const CLI::Option*> options{};

  /// Throws Error if one of them is given. Not with --rig, whose settings are for all commands.
  void refuse_for_cloud(const std::string& path) const;
};

/// The options added since `command` had `before` of them, without those that clouds have, too.
FlagsOfScans flags_of_scans(const CLI::App& command, std::size_t before,
                            const std::set<std::string>& of_clouds = {});

/// Recordings opened once for all their windows. Thread-safe.
class OpenedRecording {
 public:
  /// Null if the path is not a recording. Throws Error like RecordingReader.
  std::shared_ptr<const RecordingReader> at(const std::string& path);

  /// A folder of many windows. Throws Error like listed_folder.
  std::shared_ptr<const ListedFolder> folder_at(const std::string& path);

 private:
  std::mutex mutex_;
  std::string path_;
  std::shared_ptr<const RecordingReader> reader_;

  std::string folder_path_;
  std::shared_ptr<const ListedFolder> folder_;
};

/// Loads a scan folder or recording with its scanner, which may be unknown; with `all_cameras` also
/// the second camera's. Warnings of the reader go to `output`.
Scan load_checkable(const std::string& path, const ScanChanges& changes, bool all_cameras,
                    Output& output);

/// Chooses the scan's gamma and checks it; may reorder its frames. Prints the findings. Throws
/// Error if it cannot be reconstructed or is refused.
CheckedJob checked_scan(Scan scan, const std::string& name, const ScanJobSettings& settings,
                        Output& output);

/// Checks and reconstructs a scan; prints and lists all findings. Throws Error as ScanJob.
ScanResult result_of(Scan scan, const std::string& name, const ScanJobSettings& settings,
                     Output& output);

/// Prints how well a scan and its guard meet, after `prefix`.
void tell_guard(const EpipolarCheck& guard, const std::string& prefix, Output& output);

/// read_cloud; warns if rounding to 32 bits moves points by more than a micrometre. `unit`: mm of
/// the file's unit of length.
StoredCloud loaded_cloud(const std::string& path, Output& output, double unit = 1);

/// Rejects the cloud's points outside --box.
void keep_box(Cloud& cloud, const CleanSettings& clean);

inline const Uncertainty* uncertainty_of(const StoredCloud& stored) {
  return stored.uncertainty ? &*stored.uncertainty : nullptr;
}

/// An organised cloud in the camera's frame, from a .pcd file, or from a scan as reconstruct makes
/// it, with uncertainty if the noise is known, or is not needed as with a code's stripes. Throws
/// Error if the cloud is not organised or the scan is refused.
StoredCloud organised_cloud(const std::string& path, const ScanChanges& changes,
                            ScanJobSettings job, Output& output);

}  // namespace slipstream::app
