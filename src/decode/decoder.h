#pragma once

#include <string>
#include <vector>

#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "slipstream/maps.h"

namespace slipstream {

/// Input to unwrapping: the phase of each band and the cue of every pixel.
struct LayoutPhases {
  std::vector<PhaseMaps> bands{};  ///< in the layout's band order; grey levels of the frames
  /// With Unwrapping::vote: the cue's value, or C and S of the second band, grey levels of the
  /// frames. Otherwise empty.
  Image<double> cue{};
  Image<double> cue_sine{};
  FrameViews frames{};  ///< with a code or single frames; otherwise empty
};

/// Projector coordinate of every pixel.
struct UnwrappedPhases {
  Image<double> coordinate{};  ///< y, see BasicMaps; empty without a coordinate
  /// Largest disagreement of bands, or of cue and chosen order: see fringe_order_residual; with
  /// Unwrapping::surfaces 0, or 0.5 if the order is unknown. Empty with Unwrapping::none.
  Image<double> doubt{};
  Image<double> contrast{};  ///< with Unwrapping::code_alone: see CodeReading; otherwise empty
  Image<double> shade{};     ///< contribution of a DC cue to the mean, grey levels; otherwise empty
};

/// Each pixel on its own: see BandUnwrapper.
UnwrappedPhases unwrap_pixels(const Layout& layout, const LayoutPhases& phases,
                              int projector_length, double noise);

/// One order per connected surface, the one that fits its single frames best: 1 + cos(2 pi periods
/// y + origin), scaled by the band's modulation and one factor per surface and frame, as a lens
/// attenuates carriers differently. No order if the residual is above 4 % of the frames' sum of
/// squares, if another order has a residual less than a fifth larger, or for fewer than 2000 pixels
/// or four periods. With two bands: the order for which their phases agree, twice as well as for
/// any other. `least_modulation`: grey levels of the frames.
UnwrappedPhases unwrap_by_surfaces(const Layout& layout, const LayoutPhases& phases,
                                   double least_modulation);

/// By the cue and, depending on the rule, the neighbours: Liu 2010, Section 3.2. `grey_level`: one
/// 8-bit grey level in units of the frames.
UnwrappedPhases unwrap_by_vote(const Layout& layout, const LayoutPhases& phases,
                               const CueSettings& settings, int projector_length,
                               double grey_level);

/// Decodes frames to mean, modulation, phase and coordinate, in double. Builds tables once.
class Decoder {
 public:
  /// `projector_length`: projector pixels along the axis. Phases are corrected by the entry of
  /// `corrections` for their N. Throws Error for settings out of range.
  Decoder(Layout layout, int projector_length, PhaseMethod method,
          PhaseCorrections corrections = {}, const CueSettings& cue = {});

  /// `least_modulation`, grey levels of the frames: darker pixels do not vote on their neighbours'
  /// orders. Throws Error if the number of frames differs from the layout's.
  [[nodiscard]] BasicMaps<double> operator()(const FrameViews& frames,
                                             double least_modulation = 0) const;

  /// The two steps: frames to corrected phases; phases to coordinates. `full_scale`: of the frames.
  [[nodiscard]] LayoutPhases demodulate(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> unwrapped(LayoutPhases phases, double full_scale,
                                            double least_modulation) const;

  /// The method used for such frames, one word per band if they differ: "lut", "equation", or "lut,
  /// equation" if one of two step counts has no table.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const;

  [[nodiscard]] const Layout& layout() const { return layout_; }

 private:
  Layout layout_;
  int projector_length_;
  CueSettings cue_;
  PhaseDecoder phase_;
};

}  // namespace slipstream
