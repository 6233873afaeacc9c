#pragma once

#include <string>

#include "slipstream/base/image.h"
#include "slipstream/codes/layout.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/maps.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/decode/unwrap.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// Frames of a layout to mean, modulation, phase and projector coordinate, in double. Tables are
/// built once.
class Decoder {
 public:
  /// `projector_length`: projector pixels along the axis of the patterns. Every phase is corrected
  /// by what `corrections` has for its N. `cue`: what a cue multiplexed into the patterns needs
  /// beside them. Throws Error for settings out of range.
  Decoder(Layout layout, int projector_length, PhaseMethod method,
          PhaseCorrections corrections = {}, const CueSettings& cue = {});

  /// `least_modulation`: grey levels of the frames; where a cue is voted on, darker pixels are
  /// decoded by themselves and not asked by their neighbours. Throws Error when there are not as
  /// many frames as the layout has.
  [[nodiscard]] BasicMaps<double> operator()(const FrameViews& frames,
                                             double least_modulation = 0) const;

  /// Its two steps: frames to the phases of every band, corrected; and these to coordinates.
  /// `full_scale`: of the frames.
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
