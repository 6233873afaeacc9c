#pragma once

#include <array>

#include "geometry/triangulator.h"
#include "slipstream/engine.h"
#include "slipstream/image.h"

namespace slipstream {

inline constexpr int lens_terms = 8;  ///< coefficients of a polynomial

/// The undistorted projector coordinate minus y, for some pixels of a row: a polynomial
///   c_0 + c_1 u + ... + c_7 u^7 of u = scale (y - middle), in [-1, 1],
/// where it is fitted. Along the row, each c_k is a polynomial too, of the column counted
/// from the first one.
struct LensSegment {
  static constexpr int pixels = 16;

  float middle = 0, scale = 1;
  std::array<std::array<float, 3>, lens_terms> c{};
};

/// The polynomials of all pixels of the camera, for coordinates that their rays meet within the
/// depth range and the field: from the points that the reference engine finds, at the zeros of a
/// Chebyshev polynomial. NaN where it finds none. A segment begins at every 16th column of a row.
Image<LensSegment> lens_table(const Triangulator& triangulate, const ProjectionMatrices& matrices,
                              DepthRange depths);

/// Largest shift by the projector's lens along an axis, shares of the field; infinite if the lens
/// has no inverse somewhere in the field.
double largest_shift(const Lens& lens, Axis axis);

}  // namespace slipstream
