#pragma once

#include <cstdint>

#include "slipstream/base/image.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/codes/response.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/response/correction.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// The experiment of Liu 2010, Section 4.5, on the virtual scanner: a board, white or with a
/// texture, under PMP of 8 periods, 8-bit frames with sigma_w^2 = 1.55, averaged over repetitions.
class BoardExperiment {
 public:
  enum class Surface { white, textured };
  static constexpr double frequency = 8;
  static constexpr int repetitions = 48;

  explicit BoardExperiment(Size camera, Surface surface = Surface::white, std::uint64_t seed = 5);

  /// The mean of `count` scans of N steps by a projector of that gamma.
  [[nodiscard]] FrameSet averaged(int steps, double gamma, double ambient,
                                  int count = repetitions) const;
  /// The same of patterns that the pictures of an 8-bit projector, precompensated for `response`,
  /// make.
  [[nodiscard]] FrameSet precompensated(int steps, double gamma, double ambient,
                                        const Response& response) const;
  [[nodiscard]] FrameSet once(int steps, double gamma, double ambient) const;

  /// RMS of the error of the unwrapped phase divided by f, rad, as the paper quotes it, where
  /// `lit`.
  [[nodiscard]] double rms_error(const FrameSet& frames, const PhaseCorrections& corrections,
                                 const Image<std::uint8_t>& lit) const;
  /// The same of a wrapped phase, rad.
  [[nodiscard]] double rms_error(const Image<double>& phase, const Image<std::uint8_t>& lit) const;
  /// Error of the unwrapped phase divided by f, rad, of every pixel; NaN where the board is not
  /// lit.
  [[nodiscard]] Image<double> error(const Image<double>& phase) const;
  /// The board as that wrapped phase shows it, mm; fringe orders are the true ones. No intensity.
  [[nodiscard]] Cloud surface(const Image<double>& phase) const;
  /// Wrapped phase, rad.
  [[nodiscard]] static Image<double> phase(const FrameSet& frames,
                                           const PhaseCorrections& corrections);

 private:
  /// Each scan has noise of its own.
  [[nodiscard]] FrameSet averaged(const PatternSet& shown, Photometry light, int count) const;
  [[nodiscard]] Photometry photometry(double gamma, double ambient) const;

  std::uint64_t seed_;
  Scanner scanner_;
  VirtualScan scan_;
};

}  // namespace slipstream
