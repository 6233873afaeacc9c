#pragma once

#include <string>
#include <vector>

#include "app/live_session.h"
#include "slipstream/publish/run_setting.h"

namespace slipstream::app {

/// Whether windows of more than a cycle may do for things that move: the patterns are one sinusoid
/// shown over and over, and are read by the fused pass.
bool takes_motion(const Sequence& sequence);

/// All of these from any thread.

/// What is looked for in the frames now.
EngineSetup setup_of(LiveSession& session);
/// Looks for that in the frames from now on. Throws as LivePipeline::change.
void change_setup(LiveSession& session, const EngineSetup& setup);

/// What can be changed while the session runs: of the camera, of what becomes points, and the
/// recording, into a new file in the folder of --save-to.
std::vector<RunSetting> settings_of(LiveSession& session);
/// Throws Error as require_settable, as the camera and as LivePipeline::change, WorldError as
/// RecordedSource.
void change_setting(LiveSession& session, const std::string& name, const std::string& value);

}  // namespace slipstream::app
