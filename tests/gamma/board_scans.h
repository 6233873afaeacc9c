#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "slipstream/gamma/response.h"
#include "slipstream/image/image.h"
#include "slipstream/phase/phase_correction.h"
#include "slipstream/simulate/averaged_scan.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {

/// The experiment of Liu 2010, Section 4.5, on the virtual scanner: a board, white or veined, under
/// PMP of 8 periods, 8-bit frames with sigma_w^2 = 1.55, averaged over repetitions.
class BoardScans {
 public:
  static constexpr double frequency = 8;

  explicit BoardScans(Size camera, bool veined = false) : scanner_(example_scanner(camera)) {
    Scene board = scene_named("board", scanner_);
    if (veined) board.front().texture = veined_texture(0.35, 0.85, 40);
    scan_ = take_scan(scanner_, board, patterns(3));
  }

  [[nodiscard]] FrameSet averaged(int steps, double gamma, double ambient,
                                  int repetitions = 48) const {
    return take_averaged(scan_, patterns(steps), photometry(gamma, ambient), repetitions);
  }
  [[nodiscard]] FrameSet once(int steps, double gamma, double ambient) const {
    return take_again(scan_, patterns(steps), photometry(gamma, ambient));
  }

  /// RMS of the error of the unwrapped phase divided by f, as the paper quotes it, where `lit`.
  [[nodiscard]] double rms_error(const FrameSet& frames, const PhaseCorrections& corrections,
                                 const Image<std::uint8_t>& lit) const {
    const Decoder decode(PhaseMeasuring{frames.count(), frequency}, scanner_.projector.size.width,
                         Backend::equation, corrections);
    return rms_error(decode(frames).wrapped_phase, lit);
  }
  [[nodiscard]] double rms_error(const Image<double>& phase, const Image<std::uint8_t>& lit) const {
    constexpr double two_pi = 2 * std::numbers::pi;
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
      const double truth = two_pi * frequency * scan_.coordinate.begin()[i];
      if (lit.begin()[i] == 0 || std::isnan(truth)) continue;
      const double error = std::remainder(phase.begin()[i] - truth, two_pi);
      sum += error * error;
      ++count;
    }
    return std::sqrt(sum / count) / frequency;
  }

 private:
  static PatternSet patterns(int steps) {
    return pattern_set(PhaseMeasuring{steps, frequency}, Axis::x);
  }
  static Photometry photometry(double gamma, double ambient) {
    return {.ambient = ambient, .gamma = gamma, .noise_variance = 1.55, .bits = 8, .seed = 5};
  }

  Scanner scanner_;
  VirtualScan scan_;
};

/// Taken once for all tests of a program.
inline const BoardScans& white_board() {
  static const BoardScans board({160, 120});
  return board;
}
inline const BoardScans& veined_board() {
  static const BoardScans board({160, 120}, true);
  return board;
}

}  // namespace slipstream
