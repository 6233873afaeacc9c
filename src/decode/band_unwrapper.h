#pragma once

#include <functional>
#include <span>
#include <vector>

#include "slipstream/unwrapping.h"

namespace slipstream {

/// The projector coordinate of one pixel, for all unwrapping methods that use no other pixel.
class BandUnwrapper {
 public:
  /// `projector_length`: projector pixels along the axis. `noise`: standard deviation of the
  /// intensities, for the bits of a code alone.
  BandUnwrapper(Layout layout, int projector_length, double noise = 0);

  [[nodiscard]] PixelCoordinate operator()(const PixelReading& reading) const;

 private:
  [[nodiscard]] PixelCoordinate by_chain(std::span<const double> phases) const;
  [[nodiscard]] PixelCoordinate likeliest(std::span<const double> phases,
                                          std::span<const double> modulations) const;
  [[nodiscard]] PixelCoordinate by_code(const PixelReading& reading) const;
  /// The position with the band's phase where one mean and modulation fit all frames best, refined.
  [[nodiscard]] PixelCoordinate by_single_frames(double phi,
                                                 std::span<const double> intensities) const;
  /// Gauss-Newton refinement from a starting point within a fraction of a period.
  [[nodiscard]] double refined(double y, std::span<const double> intensities) const;
  /// Weighted coordinate of all bands, at the fringe orders nearest to y.
  [[nodiscard]] double weighed(std::span<const double> phases, double y) const;

  Layout layout_;
  int projector_length_;
  double noise_;
  std::size_t measuring_;
  std::vector<PhaseSum> chain_;
  bool circle_;
  std::vector<double> weights_;
  std::vector<SingleFrame> waves_;                           ///< with single frames: one per frame
  std::function<PixelCoordinate(const PixelReading&)> own_;  ///< for a custom method
};

}  // namespace slipstream
