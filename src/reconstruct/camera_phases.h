#pragma once

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "decode/decoder.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Modulation and phase as one complex number, B exp(i phi). Unlike the phase it has no jump at 2
/// pi, and it stays smooth where gamma distorts the phase, so it can be interpolated.
using Phasor = std::complex<float>;

/// Decoded images of one of several cameras.
struct CameraPhases {
  Maps maps{};
  /// One per band, from few periods to many, as measured: without correction for a response.
  std::vector<Image<Phasor>> bands{};
  Image<Validity> validity{};  ///< `too_dark`, `saturated` or `valid`; with a cue as Engine judges
  /// 1 where the pixel and its neighbours to the right, below and between both are valid, so that
  /// places between them can be interpolated.
  Image<std::int32_t> surrounded{};
};

/// Decodes the frames of one camera after another; reuses its memory and its result's.
class PhaseReader {
 public:
  /// `setup`: its scanner gives only sizes and photometry, without the response. Throws Error for
  /// settings out of range.
  explicit PhaseReader(const EngineSetup& setup);

  /// Throws Error if the size or number of frames is wrong.
  void operator()(const FrameViews& frames, CameraPhases& to);

  [[nodiscard]] std::string method_for(const FrameViews& frames) {
    return maps_.backend_for(frames);
  }

 private:
  void read_bands(const FrameViews& frames, CameraPhases& to) const;
  void read_maps(const FrameViews& frames, CameraPhases& to) const;
  void judge(const FrameViews& frames, CameraPhases& to) const;

  EngineSetup setup_;  ///< with the least modulation that a cue needs
  Engine maps_;
  Decoder decode_;  ///< of frames or bands that are no plain sums of quantised frames
  std::vector<std::size_t> order_;  ///< of the bands, from few periods to many
};

}  // namespace slipstream
