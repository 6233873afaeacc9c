#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "app/output.h"
#include "app/scan_flags.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/io/recording.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/response/gamma_choice.h"

namespace slipstream::app {

/// Flags that say, or say otherwise, what the frames of a scan are and what took them.
struct ScanInputFlags {
  ScanFlags scan;
  std::optional<std::string> scanner;
  std::optional<int> bits;
  std::optional<std::uint64_t> window;               ///< of a recording; no flag
  std::shared_ptr<const RecordingReader> recording;  ///< opened already; no flag
  std::string gamma = "scanner";
  PhotometricCalibration photometry;  ///< as far as flags say it
};

/// Adds --scanner, --camera-bits, --gamma, --ambient, --noise-variance and those of add_scan_flags.
void add_scan_input_flags(CLI::App& subcommand, ScanInputFlags& flags);

/// Adds --min-modulation, --keep-saturated, --nearest and --farthest.
void add_point_flags(CLI::App& subcommand, ReconstructSettings& settings);

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

/// What they say of it over what it says itself.
ScanChanges changes_of(const ScanInputFlags& flags);

/// A scan, a folder or a recording, with its scanner: what it says and the flags over that; that of
/// a second camera with it where `all_cameras`. What the frames' reader had to say goes to `output`
/// as warnings.
Scan load(const std::string& path, const ScanInputFlags& flags, bool all_cameras, Output& output);

/// The same of a scan whose scanner need not be known.
Scan load_checkable(const std::string& path, const ScanInputFlags& flags, bool all_cameras,
                    Output& output);

/// As the JSON document says it: `source`, and where there is one `gamma`, `standard_error`,
/// `pixels`, `refused`.
nlohmann::json json_of(const GammaChoice& choice);

}  // namespace slipstream::app
