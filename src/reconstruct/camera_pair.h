#pragma once

#include <string_view>

#include "reconstruct/phase_matcher.h"

// Requirements of two cameras that see one projector.
namespace slipstream {

/// Throws Error if a scanner or the setting is invalid, the projectors differ, the cameras are in
/// the same place, or their pictures have fewer than 16 pixels, or a single row or
/// column.
void require_pair(const Scanner& first, const Scanner& second, const PhaseMatchSettings& match);

/// Throws Error unless the frames have the size of the camera that `which` names.
void require_size(const FrameViews& frames, const Scanner& scanner, std::string_view which);

}  // namespace slipstream
