#pragma once

#include <string>
#include <vector>

#include "slipstream/frames/frame_views.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::app {

/// What Save does in viewer and page: writes frames, and all that is made of them, into a new
/// folder in `parent` named by the time, which reconstruct reads again. `remarks` are for the
/// cloud's header, see doubts. Without a scanner there are no points to write; frames that were
/// merged from several exposures are not written, the scan has them. Returns the folder.
/// Throws Error where the frames are not of the setup's strategy, WorldError where they cannot be
/// written.
std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks);

}  // namespace slipstream::app
