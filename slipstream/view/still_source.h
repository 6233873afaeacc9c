#pragma once

#include <optional>

#include "slipstream/frames/frame_set.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// A cloud that stands still, and how sure its points are where that is known.
ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty = std::nullopt);

/// Frames that are reconstructed anew whenever another setup is asked for; `save` is left to
/// whoever knows of files. Throws Error as Engine does.
ViewSource still_source(FrameSet frames, const EngineSetup& setup);

}  // namespace slipstream::view
