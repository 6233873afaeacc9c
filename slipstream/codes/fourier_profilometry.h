#pragma once

#include <optional>
#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"
#include "slipstream/codes/spectral_frame.h"

namespace slipstream {

/// Fourier transform profilometry: the phase of one frame of many periods, by where they stand in
/// its spectrum (Takeda and Mutoh 1983, Section 1.2), or of two, the second half a period on, whose
/// mean is then no part of it (Li et al. 1990). With a second carrier each surface has the order
/// under which both phases agree (Takeda et al. 1997). See Demodulator.
struct FourierProfilometry {
  static constexpr std::string_view name = "fourier";

  double frequency = 64;        ///< f, periods across the projector field
  bool pi_shift = false;        ///< a second frame, half a period on
  std::optional<double> low{};  ///< f_l, periods of a second carrier in the same frames, below f
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("frequency", "periods across the projector field", self.frequency);
    visit("pi_shift", "a second frame half a period on, which takes the mean away", self.pi_shift);
    visit("low", "periods of the low frequency", self.low);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  /// To sine, cosine and mean of each carrier.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
