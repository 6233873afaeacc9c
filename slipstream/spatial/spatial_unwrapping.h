#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// A way to unwrap a phase map from pixel to pixel; docs/how-to/unwrap-phase-maps.md says which to take when.
struct SpatialUnwrapping {
  std::string_view name;  ///< "quality"
  std::string_view text;  ///< what it does, in a few words
};
std::vector<SpatialUnwrapping> spatial_unwrappings();

/// Pixels that a method could connect: the phase between them is known, and to other regions not.
struct PhaseRegion {
  std::size_t pixels = 0;
  bool anchored = false;  ///< whether its phase is absolute
};

/// `Number`: float or double.
template <class Number>
struct UnwrappedPhase {
  Image<Number> phase;  ///< rad: the wrapped one and whole periods; NaN where that is not finite
  Image<int> region;    ///< from 1; 0 where there is no phase
  std::vector<PhaseRegion> regions;  ///< that of label n at n - 1; the largest first
};

/// Unwraps a phase in rad, which may lie in any interval; where it is not finite there is none. A
/// `quality`, as the modulation, is of the same size, more where the phase is surer, and none or
/// not finite where nothing is known; without any, the empty image. The first pixel of a region,
/// row by row, keeps the phase that it has. Throws Error where the sizes differ, the name is none
/// of spatial_unwrappings() or a phase is beyond 10^6 rad.
template <class Number>
UnwrappedPhase<Number> unwrap_in_space(const Image<Number>& wrapped,
                                       const Image<float>& quality = {},
                                       std::string_view method = "flow");

/// Moves the pixel's region by whole periods to the nearest of `phase`, rad, at the pixel. Throws
/// Error where the pixel has no region or `phase` is not finite.
template <class Number>
void anchor_at(UnwrappedPhase<Number>& unwrapped, int column, int row, double phase);

/// The same of each region by a coarse absolute phase, rad, NaN where that is not known: the median
/// of the differences over the region decides. Throws Error where the sizes differ.
template <class Number>
void anchor_by(UnwrappedPhase<Number>& unwrapped, const Image<Number>& coarse);

}  // namespace slipstream
