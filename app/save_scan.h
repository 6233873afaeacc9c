#pragma once

#include <filesystem>
#include <string>

#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_pipeline.h"

namespace slipstream::app {

/// Writes what a cloud was made of, and all that was made of it, into a new folder in `parent`
/// named by the time: the frames with scan.yaml and scanner.yaml, which reconstruct reads again,
/// cloud.ply, depth.tiff, coordinate.tiff, phase.tiff, modulation.tiff, mean.tiff and preview.png.
/// Returns the folder. Throws Error where the frames are not of the scan's strategy, WorldError
/// where they cannot be written.
std::string save_scan(const LiveCloud& cloud, const LiveScan& scan,
                      const std::filesystem::path& parent);

}  // namespace slipstream::app
