#pragma once

#include <span>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/unwrapping.h"

namespace slipstream {

/// Fringe order k of Liu 2010, Eq. (1.17): the whole number of periods that must be added to
/// `wrapped_phase` (rad, [0, 2 pi), of `frequency` periods across the field) to come nearest to
/// `coarse_coordinate`, the projector coordinate that a lower frequency gave. Not limited to the
/// field: see coordinate_in_field.
int fringe_order(double wrapped_phase, double frequency, double coarse_coordinate);

/// How far, in periods of `frequency`, the coarse coordinate lies from the one that this fringe
/// order gives: within [-0.5, 0.5], near 0 where low and high frequency agree. Towards either end
/// another fringe order is as likely.
double fringe_order_residual(double wrapped_phase, double frequency, double coarse_coordinate,
                             int fringe_order);

/// Projector coordinate (phi + 2 pi k) / (2 pi f), Eqs. (1.8) and (1.17).
double unwrapped_coordinate(double wrapped_phase, int fringe_order, double frequency);

/// Brings a coordinate that is known up to whole multiples of `period` (>= 1, in fields) into the
/// field. Pixel centres are at integers, so the field of a projector `projector_length` pixels long
/// runs from -0.5 / projector_length to 1 - 0.5 / projector_length; the circle is cut in the middle
/// of what is not lit. Noise at one end of the field thereby stays at that end, up to half a pixel
/// and half the unlit part.
double coordinate_in_field(double coordinate, double period, int projector_length);

/// The projector coordinate of one pixel by every unwrapping that asks no other pixel.
class BandUnwrapper {
 public:
  /// `projector_length`: projector pixels along the axis.
  BandUnwrapper(Layout layout, int projector_length);

  /// What one pixel's frames say.
  struct Reading {
    std::span<const double> phases;  ///< of all bands, rad, [0, 2 pi)
    std::span<const double> modulations;
    /// Of all frames, with a code or single frames; else what there is.
    std::span<const double> intensities;
  };
  struct Coordinate {
    double y = 0;      ///< see BasicMaps
    double doubt = 0;  ///< the most of all steps, see fringe_order_residual; of a code beyond what
                       ///< its stripes leave open; of single frames half of the least misfit over
                       ///< that of the next order
    double contrast = 0;  ///< with Unwrapping::code_alone: see CodeReading
  };
  [[nodiscard]] Coordinate operator()(const Reading& reading) const;

  /// Whether anything could contradict the fringe order.
  [[nodiscard]] bool can_doubt() const;

 private:
  struct Wave {
    double periods = 1;
    double shift = 0;  ///< cos(2 pi periods y - shift)
  };

  [[nodiscard]] Coordinate by_chain(std::span<const double> phases) const;
  [[nodiscard]] Coordinate likeliest(std::span<const double> phases,
                                     std::span<const double> modulations) const;
  [[nodiscard]] Coordinate by_code(const Reading& reading) const;
  /// Of the places with the band's phase that under which all frames fit one mean and one
  /// modulation best, by least squares, and then its neighbourhood.
  [[nodiscard]] Coordinate by_single_frames(double phi, std::span<const double> intensities) const;
  /// By Gauss and Newton, from a place within a part of a period.
  [[nodiscard]] double refined(double y, std::span<const double> intensities) const;
  /// That of all bands, at the fringe orders next to y.
  [[nodiscard]] double weighed(std::span<const double> phases, double y) const;

  Layout layout_;
  int projector_length_;
  std::size_t measuring_;
  std::vector<PhaseSum> chain_;
  bool circle_;
  std::vector<double> weights_;
  std::vector<Wave> waves_;  ///< with single frames: of every frame
};

}  // namespace slipstream
