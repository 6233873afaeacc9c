#pragma once

#include <string>

#include "app/clean_flags.h"
#include "app/scan_findings.h"
#include "app/scan_input.h"
#include "slipstream/io/stored_cloud.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::app {

/// The flags of what makes clouds of scans.
struct CloudInputFlags {
  ScanInputFlags input;
  ReconstructSettings settings;
  CleanFlags clean;
  bool anyway = false;
};

/// Adds --anyway and those of points, cleaning and scans.
void add_cloud_input_flags(CLI::App& subcommand, CloudInputFlags& flags);

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
