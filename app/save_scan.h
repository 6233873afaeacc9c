#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/gamma_choice.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_pipeline.h"

namespace slipstream::app {

/// What is known of the scanner of the scans that are saved.
struct SavedScanner {
  std::string text;                        ///< of a scanner file, YAML or XML
  std::string name;                        ///< what a message calls it
  PhotometricCalibration photometry = {};  ///< what flags say in place of the text
  std::vector<GammaChoice> gammas = {};    ///< that the phase may have been corrected by
};

/// A path in `parent` that is not there yet, named by the time: "WHAT-20260131-142530ENDING", with
/// -2, -3 and so on before the ending where there is one already.
std::filesystem::path path_named_by_time(const std::filesystem::path& parent, std::string_view what,
                                         std::string_view ending);

/// Writes what a cloud was made of, and all that was made of it, into a new folder in `parent`
/// named by the time: the frames with scan.yaml and the scanner's text as scanner.yaml or .xml,
/// with the gamma that the phase was corrected by, all of which reconstruct reads again, cloud.ply,
/// depth.tiff, coordinate.tiff, phase.tiff, modulation.tiff, mean.tiff and preview.png. Returns the
/// folder. Throws Error where the frames are not of the scan's strategy, WorldError where they
/// cannot be written.
std::string save_scan(const LiveCloud& cloud, const LiveScan& scan, const SavedScanner& scanner,
                      const std::filesystem::path& parent);

}  // namespace slipstream::app
