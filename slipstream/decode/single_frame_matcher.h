#pragma once

#include <span>
#include <utility>
#include <vector>

#include "slipstream/codes/layout.h"

namespace slipstream {

/// The coordinate of one pixel by a band and single frames: of the places with the band's phase
/// that under which all frames fit one mean and one modulation best, by least squares, and then its
/// neighbourhood.
class SingleFrameMatcher {
 public:
  /// Of a layout with Unwrapping::single_frames.
  SingleFrameMatcher(const Layout& layout, int projector_length);

  /// The coordinate, and half of its misfit over that of the next best order. `phi`: of the band;
  /// `intensities`: of all frames.
  [[nodiscard]] std::pair<double, double> operator()(double phi,
                                                     std::span<const double> intensities) const;

 private:
  struct Wave {
    double periods = 1;
    double shift = 0;  ///< cos(2 pi periods y - shift)
  };

  /// By Gauss and Newton, from a place within a part of a period.
  [[nodiscard]] double refined(double y, std::span<const double> intensities) const;

  std::vector<Wave> waves_;  ///< of every frame
  double periods_;           ///< of the band
  double first_;             ///< where the field begins
};

}  // namespace slipstream
