#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/output.h"
#include "app/view_flags.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {

/// What the viewer's Save does: writes frames, and all that is made of them, into a new folder
/// named by the time where --save-to says, which reconstruct reads again. `remarks` are for the
/// cloud's header, see doubts. Without a scanner there are no points to write; frames that were
/// merged from several exposures are not written, the scan has them. Returns the folder.
/// Throws Error where the frames are not of the setup's strategy, WorldError where they cannot be
/// written.
std::string save_in_new_folder(const view::ShownCloud& cloud, const EngineSetup& setup,
                               const ViewFlags& flags, const std::vector<std::string>& remarks);

/// Writes a picture and says so, under its name.
void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output);

/// Draws --snapshot and --screenshot without a window, as far as they are given.
void write_snapshot(const view::ViewSource& source, const ViewFlags& flags, Output& output);
void write_screenshot(const view::ViewSource& source, const ViewFlags& flags, Output& output);

}  // namespace slipstream::app
