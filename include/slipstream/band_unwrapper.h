#pragma once

#include "slipstream/unwrapping.h"

namespace slipstream {

/// Fringe order k, Liu 2010, Eq. (1.17): the periods to add to `wrapped_phase` (rad, [0, 2 pi),
/// `frequency` periods across the field) to come nearest to `coarse_coordinate`, the coordinate
/// from a lower frequency. Not limited to the field: see coordinate_in_field.
int fringe_order(double wrapped_phase, double frequency, double coarse_coordinate);

/// Distance, in periods of `frequency`, of the coarse coordinate from the one with this fringe
/// order: [-0.5, 0.5], near 0 if the frequencies agree; at either end another order is as likely.
double fringe_order_residual(double wrapped_phase, double frequency, double coarse_coordinate,
                             int fringe_order);

/// Projector coordinate (phi + 2 pi k) / (2 pi f), Eqs. (1.8) and (1.17).
double unwrapped_coordinate(double wrapped_phase, int fringe_order, double frequency);

/// Brings a coordinate known up to whole multiples of `period` (>= 1, in fields) into the field:
/// -0.5 / projector_length to 1 - 0.5 / projector_length, as pixel centres are at integers. The
/// circle is cut in the middle of its unlit part, so that noise at one end of the field stays at
/// that end, up to half a pixel and half the unlit part.
double coordinate_in_field(double coordinate, double period, int projector_length);

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
