#pragma once

#include <string>

#include "app/clean_flags.h"
#include "app/scan_input.h"
#include "slipstream/io/stored_cloud.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::app {

/// The flags of what measures in clouds.
struct CloudInputFlags {
  ScanInputFlags input;
  ReconstructSettings settings;
  CleanFlags clean;
  bool anyway = false;
};

/// Adds --anyway and those of points, cleaning and scans.
void add_cloud_input_flags(CLI::App& subcommand, CloudInputFlags& flags);

/// An organised cloud: of a .pcd file, or of a scan as reconstruct makes it, with how sure it is
/// where the noise is known. Throws Error for a cloud that is not organised, or a scan that is
/// refused.
StoredCloud organised_cloud(const std::string& path, const CloudInputFlags& flags, Output& output);

}  // namespace slipstream::app
