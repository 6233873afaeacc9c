#pragma once

#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/maps.h"
#include "slipstream/decode/phase_decoder.h"

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
  /// Most disagreement of bands, or of cue and order chosen: see fringe_order_residual; with
  /// Unwrapping::surfaces 0, or 0.5 if the surface's order is unknown. Empty with Unwrapping::none.
  Image<double> doubt{};
  Image<double> contrast{};  ///< with Unwrapping::code_alone: see CodeReading; else empty
  Image<double>
      shade{};  ///< what a cue in the DC channel adds to the mean, grey levels; else empty
};

/// Each pixel by itself: see BandUnwrapper. `projector_length`: projector pixels along the axis.
UnwrappedPhases unwrap_pixels(const Layout& layout, const LayoutPhases& phases,
                              int projector_length);

/// Each connected surface by the order under which its single frames fit best: 1 + cos(2 pi periods
/// y + origin), as bright as the band is strong, times one number a surface and frame, as a lens
/// attenuates carriers differently. None if more than 4 % of the frames' squares are left, another
/// order leaves less than a fifth more, or for less than 2000 pixels or four periods. Of two bands
/// instead: the order under which their phases agree, twice as well as under any other.
/// `least_modulation`: grey levels of the frames.
UnwrappedPhases unwrap_by_surfaces(const Layout& layout, const LayoutPhases& phases,
                                   double least_modulation);

/// By the cue, and the neighbours where the rule asks them: Liu 2010, Section 3.2. `grey_level`:
/// one of 8 bits in those of the frames.
UnwrappedPhases unwrap_by_vote(const Layout& layout, const LayoutPhases& phases,
                               const CueSettings& settings, int projector_length,
                               double grey_level);

/// Frames of a layout to mean, modulation, phase and coordinate, in double. Tables are built once.
class Decoder {
 public:
  /// `projector_length`: projector pixels along the axis. Phases are corrected by what
  /// `corrections` has for their N. Throws Error for settings out of range.
  Decoder(Layout layout, int projector_length, PhaseMethod method,
          PhaseCorrections corrections = {}, const CueSettings& cue = {});

  /// `least_modulation`: grey levels of the frames; darker pixels have no vote in their neighbours'
  /// orders. Throws Error for another number of frames than the layout's.
  [[nodiscard]] BasicMaps<double> operator()(const FrameViews& frames,
                                             double least_modulation = 0) const;

  /// Its two steps: frames to corrected phases; these to coordinates. `full_scale`: of the frames.
  [[nodiscard]] LayoutPhases demodulate(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> unwrapped(LayoutPhases phases, double full_scale,
                                            double least_modulation) const;

  /// The method that decodes such frames, one word for each band that differs: "lut", "equation",
  /// or "lut, equation" where one of two step counts has no table.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const;

  [[nodiscard]] const Layout& layout() const { return layout_; }

 private:
  Layout layout_;
  int projector_length_;
  CueSettings cue_;
  PhaseDecoder phase_;
};

}  // namespace slipstream
