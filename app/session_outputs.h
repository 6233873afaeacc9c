#pragma once

#include <string>
#include <vector>

#include "slipstream/engine.h"

namespace slipstream::app {

/// Save in viewer and page: writes frames and results into a new folder in `parent`, named by the
/// time, which reconstruct can read. `remarks` go into the cloud's header, see doubts. Without a
/// scanner no points are written; frames merged from several exposures are not written. Returns the
/// folder. Throws Error if the frames do not fit the setup's strategy, WorldError if they cannot be
/// written.
std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks);

}  // namespace slipstream::app
