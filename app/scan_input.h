#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/findings.h"
#include "app/scan_flags.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/recording.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/response/gamma_choice.h"

namespace slipstream::app {

/// What flags say over what a scan says itself: its frames and what took them.
struct ScanInputFlags {
  ScanChanges changes;
  std::string gamma = "scanner";
  PhotometricCalibration photometry;  ///< as far as flags say it
};

/// Adds --scanner, --camera-bits, --gamma, --ambient, --noise-variance and those of add_scan_flags.
void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags);

/// Adds --backend.
void add_backend_flag(const FlagGroup& group, ReconstructSettings& settings);

/// Adds --min-modulation, --keep-saturated, --nearest and --farthest.
void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings);

/// Adds --raw, which also takes the limits of depth away, and the flags of `settings.clean`.
void add_clean_flags(CLI::App& subcommand, ReconstructSettings& settings);

/// The flags of what makes clouds of scans.
struct CloudInputFlags {
  ScanInputFlags input;
  ReconstructSettings settings;
  bool anyway = false;
};

/// Adds --anyway and those of points, cleaning and scans.
void add_cloud_input_flags(CLI::App& subcommand, CloudInputFlags& flags);

/// Of the windows of a recording the first opens it for all. Thread-safe.
class OpenedRecording {
 public:
  /// None where there is no recording. Throws Error as RecordingReader.
  std::shared_ptr<const RecordingReader> at(const std::string& path);

 private:
  std::mutex mutex_;
  std::string path_;
  std::shared_ptr<const RecordingReader> reader_;
};

/// A scan, a folder or a recording, with its scanner: what it says and the flags over that; that of
/// a second camera with it where `all_cameras`. What the frames' reader had to say goes to `output`
/// as warnings.
Scan load(const std::string& path, const ScanInputFlags& flags, bool all_cameras, Output& output);

/// The same of a scan whose scanner need not be known.
Scan load_checkable(const std::string& path, const ScanInputFlags& flags, bool all_cameras,
                    Output& output);

/// A scan that the check did not refuse.
struct SoundScan {
  EngineSetup setup;  ///< of what reconstructs it
  GammaChoice gamma;  ///< that its phases are corrected for
  CheckedScan checked;
  double choosing = 0, checking = 0;  ///< s that both took
};

/// Chooses the scan's gamma and checks it; its frames may have been put in order. Throws Error
/// where it cannot be reconstructed or is refused.
SoundScan sound_scan(Scan& scan, const std::string& name, const CloudInputFlags& flags,
                     Output& output);

/// An organised cloud: of a .pcd file, or of a scan as reconstruct makes it, with how sure it is
/// where the noise is known. Throws Error for a cloud that is not organised, or a scan that is
/// refused.
StoredCloud organised_cloud(const std::string& path, const CloudInputFlags& flags, Output& output);

}  // namespace slipstream::app
