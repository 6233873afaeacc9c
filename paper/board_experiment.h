#pragma once

#include <cstdint>

#include "decode/phase_decoder.h"
#include "response/correction.h"
#include "slipstream/cloud.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"
#include "slipstream/response.h"
#include "slipstream/scanner.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// Experiment of Liu 2010, Section 4.5, on the virtual scanner: a board, white or veined, or a
/// painted fish under PMP of 8 periods, 8-bit frames with sigma_w^2 = 1.55, averaged over
/// repetitions.
class BoardExperiment {
 public:
  enum class Surface { white, textured, fish };
  static constexpr double frequency = 8;
  static constexpr int repetitions = 48;

  explicit BoardExperiment(Size camera, Surface surface = Surface::white, std::uint64_t seed = 5);

  /// Mean of `count` scans of N steps from a projector with this gamma.
  [[nodiscard]] FrameSet averaged(int steps, double gamma, double ambient,
                                  int count = repetitions) const;
  /// The same with 8-bit patterns that are precompensated for `response`.
  [[nodiscard]] FrameSet precompensated(int steps, double gamma, double ambient,
                                        const Response& response) const;
  /// Frames of uniform patterns from black to white, for a curve fit.
  [[nodiscard]] FrameSet grey_levels(int count, double gamma, double ambient) const;
  [[nodiscard]] FrameSet once(int steps, double gamma, double ambient) const;

  /// RMS error of the unwrapped phase divided by f, rad, as in the paper, over the pixels `lit`.
  [[nodiscard]] double rms_error(const FrameSet& frames, const PhaseCorrections& corrections,
                                 const Image<std::uint8_t>& lit) const;
  /// The same for a wrapped phase, rad.
  [[nodiscard]] double rms_error(const Image<double>& phase, const Image<std::uint8_t>& lit) const;
  /// Error of the unwrapped phase divided by f, rad, per pixel; NaN where the board is not lit.
  [[nodiscard]] Image<double> error(const Image<double>& phase) const;
  /// Surface from a wrapped phase and the true fringe orders, mm. No intensity.
  [[nodiscard]] Cloud surface(const Image<double>& phase) const;
  /// Wrapped phase, rad.
  [[nodiscard]] static Image<double> phase(const FrameSet& frames,
                                           const PhaseCorrections& corrections);

 private:
  /// Each scan has its own noise.
  [[nodiscard]] FrameSet averaged(const PatternSet& shown, Photometry light, int count) const;
  [[nodiscard]] Photometry photometry(double gamma, double ambient) const;

  std::uint64_t seed_;
  Scanner scanner_;
  VirtualScan scan_;
};

}  // namespace slipstream
