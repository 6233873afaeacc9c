#pragma once

#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"
#include "slipstream/codes/symbol_grid.h"

namespace slipstream {

/// A frame that nothing shows: it is taken out of the spectrum of frames that hold several things
/// at once, each around a carrier of its own.
struct SpectralFrame {
  enum class Kind {
    mean,      ///< what is left without the carriers
    sinusoid,  ///< the mean and B / 2 cos(phi - angle) of the carrier's phase phi: half of B, for
               ///< no level is below 0, and the local mean may be below B
    envelope,  ///< how strong the carrier is
  };

  Kind kind = Kind::mean;
  double periods = 1;   ///< of the carrier, across the field
  bool across = false;  ///< the carrier runs across the axis, not along it
  double angle = 0;     ///< rad
  double share = 1;     ///< of the modulation: of the carrier; levels are those of a full one

  friend bool operator==(const SpectralFrame&, const SpectralFrame&) = default;
};

/// How frames that are shown become those that are read.
struct Demodulation {
  int shown = 1;  ///< frames; of two the second has all carriers half a period on
  std::vector<SpectralFrame> frames{};
  /// Where not empty, what is shown: of three frames stripes, of one symbols, by which every pixel
  /// has a place in the field, and all carriers their phases.
  SymbolGrid grid{};

  friend bool operator==(const Demodulation&, const Demodulation&) = default;
};

/// Sine, cosine and mean of a carrier along the axis, and the band that they make from frame
/// `first` of `frames` on.
std::vector<SpectralFrame> sine_cosine_mean(double periods, double share = 1);
Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts = {});
/// What would show frame n of these three: in [0, 1].
double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts = {});

}  // namespace slipstream
