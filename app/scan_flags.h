#pragma once

#include <memory>
#include <mutex>

#include "app/commands.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/response/gamma.h"

namespace slipstream::app {

/// Adds --strategy, a flag for each setting of the registry, --axis, --projector, --alpha-p,
/// --beta-p, --exposures, --motion and --binary; `with_marker` also --marker, for what shows
/// patterns again and again, or sees them. A switch also has its opposite: --no-backwards.
void add_pattern_flags(CLI::App& subcommand, SequenceChanges& changes, bool with_marker = false);

/// Adds those of add_pattern_flags but --binary, and --order, for what reads scans.
void add_scan_flags(CLI::App& subcommand, ScanChanges& changes);

/// Whether the word is a flag that switches a setting of patterns on.
bool is_pattern_switch(const std::string& word);

/// What flags say over what a scan says itself: its frames and what took them.
struct ScanFlags : ScanChanges {
  std::string gamma = "scanner";
  PhotometricCalibration photometry;  ///< what flags say of it
};

/// Adds --scanner, --camera-bits, --gamma, --ambient, --noise-variance and those of add_scan_flags.
void add_scan_input_flags(CLI::App& subcommand, ScanFlags& flags);

/// Adds --anyway.
void add_anyway_flag(CLI::App& subcommand, bool& anyway);

/// Adds --backend.
void add_backend_flag(const FlagGroup& group, ReconstructSettings& settings);

/// Adds --min-modulation, --keep-saturated, --nearest and --farthest.
void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings);

/// Adds --raw, which also removes the limits of depth, and the flags of `settings.clean`.
void add_clean_flags(CLI::App& subcommand, ReconstructSettings& settings);

/// The flags of what makes clouds of scans.
struct CloudFlags : ScanFlags {
  ReconstructSettings settings;
  bool anyway = false;
};

/// Adds --anyway and those of points, cleaning and scans.
void add_cloud_flags(CLI::App& subcommand, CloudFlags& flags);

/// Of the windows of a recording the first opens it for all. Thread-safe.
class OpenedRecording {
 public:
  /// Null for what is not a recording. Throws Error as RecordingReader.
  std::shared_ptr<const RecordingReader> at(const std::string& path);

 private:
  std::mutex mutex_;
  std::string path_;
  std::shared_ptr<const RecordingReader> reader_;
};

/// A scan, a folder or a recording, with its scanner, changed by the flags; that of a second camera
/// with it if `all_cameras`. Warnings of the frames' reader go to `output`.
Scan load(const std::string& path, const ScanFlags& flags, bool all_cameras, Output& output);

/// The same of a scan whose scanner need not be known.
Scan load_checkable(const std::string& path, const ScanFlags& flags, bool all_cameras,
                    Output& output);

/// A scan that the check did not refuse.
struct SoundScan {
  EngineSetup setup;  ///< of what reconstructs it
  GammaChoice gamma;  ///< that its phases are corrected for
  CheckedScan checked;
  double choosing = 0, checking = 0;  ///< s that both took
};

/// Chooses the scan's gamma and checks it; its frames may have been put in order. Throws Error if
/// it cannot be reconstructed or is refused.
SoundScan sound_scan(Scan& scan, const std::string& name, const CloudFlags& flags, Output& output);

inline const Uncertainty* uncertainty_of(const StoredCloud& stored) {
  return stored.uncertainty ? &*stored.uncertainty : nullptr;
}

/// An organised cloud: of a .pcd file, or of a scan as reconstruct makes it, with its uncertainty
/// if the noise is known. Throws Error for a cloud that is not organised, or a scan that is
/// refused.
StoredCloud organised_cloud(const std::string& path, const CloudFlags& flags, Output& output);

}  // namespace slipstream::app
