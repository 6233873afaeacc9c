#pragma once

#include <array>
#include <complex>
#include <optional>

#include "check/judged_scan.h"

namespace slipstream {

/// The light over a period of the patterns, which is not quite a sinusoid: g(a) = cos(a) + the sum
/// of Re(h_k exp(i k a)) over k > 1. The response of projector and camera makes it, and stripes of
/// one bit. It is the same in all pixels and bands, unlike the rest that a mistake leaves.
struct Waveform {
  static constexpr int most_harmonic = 5;

  /// h_k by k; 0 where these numbers of steps cannot show it.
  std::array<std::complex<double>, most_harmonic + 1> harmonics{};
  double residual = 0;     ///< as FrameEvidence::residual, of the part that it does not explain
  double phase_error = 0;  ///< of the measuring band, RMS, rad: by harmonics that N steps let pass

  /// Whether it explains nearly all of a residual, and is one that light has: the same before
  /// and after its crest. Frames in a wrong order leave more, or another form.
  [[nodiscard]] bool explains(double residual_without) const;

  /// As of stripes of one bit.
  [[nodiscard]] bool is_odd() const { return std::abs(harmonics[3]) > std::abs(harmonics[2]); }
};

/// Whether all bands are runs of equal steps, four or more in the measuring one.
bool can_show_waveform(const FrameModel& model);

/// RMS error, rad, that the waveform of a scan's frames leaves in the measuring band's phase after
/// correction for the response in `photometry`. nullopt if the frames cannot show it, or without
/// lit pixels. `least_modulation`: grey levels of 255.
std::optional<double> phase_error_left(const FrameViews& frames, const Sequence& sequence,
                                       const PhotometricCalibration& photometry,
                                       double least_modulation);

/// By least squares over the samples. nullopt if the frames cannot show it, or of what moves.
std::optional<Waveform> waveform_of(const FrameModel& model, const JudgedScan& scan,
                                    const FrameOrder& order);

}  // namespace slipstream
