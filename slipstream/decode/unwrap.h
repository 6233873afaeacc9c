#pragma once

#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/layout.h"
#include "slipstream/decode/cue_settings.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream {

/// What is unwrapped: of every pixel the phase of each band, and what its cue says.
struct LayoutPhases {
  std::vector<PhaseMaps> bands{};  ///< in the order of the layout's; grey levels of the frames
  /// With Unwrapping::vote: the cue's number, or C and S of the second band, grey levels of the
  /// frames. Else empty.
  Image<double> cue{};
  Image<double> cue_sine{};
  FrameViews frames{};  ///< with a code or single frames; else empty
};

/// Where every pixel is on the projector's axis.
struct UnwrappedPhases {
  Image<double> coordinate{};  ///< y, see BasicMaps; empty where the layout gives none
  /// How far the bands are apart on the fringe order, the most of all steps from band to band, or
  /// the cue from the order chosen: see fringe_order_residual; with Unwrapping::surfaces 0, or 0.5
  /// where the surface's order is not known. Empty with Unwrapping::none.
  Image<double> doubt{};
  Image<double> contrast{};  ///< with Unwrapping::code_alone: see CodeReading; else empty
  Image<double>
      shade{};  ///< what a cue in the DC channel adds to the mean, grey levels; else empty
};

/// The coordinate by the layout's rule: see BandUnwrapper; or the cue and the neighbours, Liu 2010,
/// Section 3.2. `projector_length`: projector pixels along the axis; `grey_level`: one
/// of 8 bits in those of the frames.
UnwrappedPhases unwrap(const Layout& layout, const LayoutPhases& phases, const CueSettings& cue,
                       int projector_length, double grey_level);

}  // namespace slipstream
