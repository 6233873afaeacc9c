#pragma once

#include <string>
#include <vector>

#include "app/live_session.h"

namespace slipstream::app {

/// Labels of this strategy, and of common ones that a projector may show instead.
std::vector<std::string> strategy_labels(const Strategy& given);

/// Whether motion compensation is possible: the patterns are one sinusoid, or PCMP's two in the
/// same frames, shown repeatedly.
bool takes_motion(const Sequence& sequence);

/// The setup in use. Callable from any thread, like the next three.
EngineSetup setup_of(LiveSession& session);

/// Looks for this sequence from now on. Throws like LivePipeline::change.
void change_setup(LiveSession& session, const EngineSetup& setup);

/// Settings that can change while the session runs: camera, point selection, and recording into a
/// new file in the --save-to folder.
std::vector<RunSetting> settings_of(LiveSession& session);
/// Throws Error like require_settable, the camera and LivePipeline::change, and WorldError like
/// RecordedSource.
void change_setting(LiveSession& session, const std::string& name, const std::string& value);

}  // namespace slipstream::app
