#pragma once

#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/layout.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/frames/frame_set.h"

// What ways of unwrapping do with a whole picture, by OrderSource.
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

/// Each pixel by itself: see BandUnwrapper. `projector_length`: projector pixels along the axis.
UnwrappedPhases unwrap_pixels(const Layout& layout, const LayoutPhases& phases,
                              int projector_length);

/// Each connected surface by the order under which its single frames fit best: they show
/// 1 + cos(2 pi periods y + origin), as bright as the band is strong, times one number for all of
/// the surface, which need not be that of the other frames: a lens takes more away of one carrier
/// than of another. None where more than 4 % of the frames' squares are left, where another order
/// leaves less than a fifth more, and of surfaces of less than 2000 pixels or four periods. Of two
/// bands instead: that under which their phases agree, twice as well as under any other.
/// `least_modulation`: grey levels of the frames.
UnwrappedPhases unwrap_by_surfaces(const Layout& layout, const LayoutPhases& phases,
                                   double least_modulation);

/// By the cue, and the neighbours where the rule asks them: Liu 2010, Section 3.2. `grey_level`:
/// one of 8 bits in those of the frames.
UnwrappedPhases unwrap_by_vote(const Layout& layout, const LayoutPhases& phases,
                               const CueSettings& settings, int projector_length,
                               double grey_level);

}  // namespace slipstream
