#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/scan_flags.h"
#include "slipstream/viewer.h"

namespace slipstream::app {

/// Flags of everything that draws clouds.
struct ViewFlags {
  std::string snapshot;    ///< picture without the panel; no file if empty
  std::string screenshot;  ///< picture with it
  Size size{1280, 800};
  view::ViewSettings settings{};
  std::string save_to = ".";
};

// The functions exist in builds with SLIPSTREAM_VIEW.

/// Adds --snapshot, --screenshot, --size, --colour and --save-to.
void add_view_flags(CLI::App& subcommand, ViewFlags& flags);

/// Throws Error for a picture file with an unknown extension.
void require_good(const ViewFlags& flags);

/// Shows clouds in a window until `ends` or it is closed; then writes the requested screenshot.
void show_in_window(view::ViewSource source, const ViewFlags& flags,
                    const std::function<bool()>& ends, Output& output);

/// Draws --snapshot and, if requested, --screenshot without a window. Throws WorldError without a
/// cloud.
void write_pictures(const view::ViewSource& source, const ViewFlags& flags, bool screenshot_too,
                    Output& output);

/// A scan, a recording or a cloud, named `path`.
view::ViewSource view_source_of(const std::string& path, const ScanChanges& changes,
                                const ScanJobSettings& job, const ViewFlags& view, Output& output);

/// Viewable scan folders and files in a folder, newest first.
std::vector<std::string> viewable_in(const fs::path& folder);

}  // namespace slipstream::app
