#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/live_session.h"

namespace slipstream::app {

/// Throws Error if the session's clouds cannot be saved.
void require_saveable(const LiveSession& session);

/// Throws Error if frames of that sequence do not fit the setup: it has changed since.
void require_sequence(const Sequence& of_frames, const EngineSetup& setup);

/// Opens the --publish sinks before the session starts. `document` returns the current --json
/// document; called from any thread.
void open_sinks(LiveSession& session, const std::function<nlohmann::json()>& document);

/// Save in viewer and page: writes frames and results into a new folder in `parent`, named by the
/// time, which reconstruct can read. `remarks` go into the cloud's header, see doubts. Without a
/// scanner no points are written; frames merged from several exposures are not written. Returns the
/// folder. Throws Error if the frames do not fit the setup's strategy, WorldError if they cannot be
/// written.
std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks);

}  // namespace slipstream::app
