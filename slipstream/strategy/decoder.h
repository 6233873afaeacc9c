#pragma once

#include <string>

#include "slipstream/capture/frame_set.h"
#include "slipstream/phase/phase_decoder.h"
#include "slipstream/strategy/cue_settings.h"
#include "slipstream/strategy/decoded_scan.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// Frames of a strategy to mean, modulation, phase and projector coordinate. Tables are built once.
class Decoder {
 public:
  /// `length`: projector pixels along the axis of the patterns. Every phase is corrected by what
  /// `corrections` has for its N. `cue`: what a cue multiplexed into the patterns needs beside
  /// them. Throws Error for a strategy whose settings are out of range or too fine for that
  /// projector.
  Decoder(Strategy strategy, int length, Backend backend, PhaseCorrections corrections = {},
          const CueSettings& cue = {});

  /// `least_modulation`: grey levels of the frames; darker pixels are decoded by themselves and not
  /// asked by their neighbours. Throws Error when there are not as many frames as the strategy has
  /// patterns.
  [[nodiscard]] DecodedScan operator()(const FrameSet& frames, double least_modulation = 0) const;

  /// The backend that decodes such frames, one word for each sinusoid that differs: "lut",
  /// "equation", or "lut, equation" where one of two step counts has no table; "equation" for a
  /// strategy without sinusoids.
  [[nodiscard]] std::string backend_for(const FrameSet& frames) const;

 private:
  Strategy strategy_;
  int length_;
  CueSettings cue_;
  PhaseDecoder phase_;
};

}  // namespace slipstream
