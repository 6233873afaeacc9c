#pragma once

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

}  // namespace slipstream
