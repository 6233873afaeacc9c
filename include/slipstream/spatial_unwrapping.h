#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// A spatial phase unwrapping method; see docs/how-to/unwrap-phase-maps.md for the choice.
struct SpatialUnwrapping {
  std::string_view name;  ///< "quality"
  std::string_view text;  ///< short description
};

std::vector<SpatialUnwrapping> spatial_unwrappings();

/// Connected pixels: the phase between them is known, but not relative to other regions.
struct PhaseRegion {
  std::size_t pixels = 0;
  bool anchored = false;  ///< whether its phase is absolute
};

/// `Number`: float or double.
template <class Number>
struct UnwrappedPhase {
  Image<Number> phase;  ///< rad: wrapped phase plus whole periods; NaN if that is not finite
  Image<int> region;    ///< label from 1; 0 without a phase
  std::vector<PhaseRegion> regions;  ///< region of label n at n - 1; largest first
};

/// Unwraps a phase in rad, from any interval; pixels that are not finite have no phase. `quality`,
/// such as the modulation: same size, higher for more reliable phase; 0 or not finite if unknown;
/// optional. The first pixel of a region, row by row, keeps its phase. Throws Error
/// if the sizes differ, the method is not in spatial_unwrappings() or a phase exceeds 10^6 rad.
template <class Number>
UnwrappedPhase<Number> unwrap_in_space(const Image<Number>& wrapped,
                                       const Image<float>& quality = {},
                                       std::string_view method = "flow");

/// Shifts the pixel's region by whole periods, so that its phase at the pixel is nearest to
/// `phase`, rad. Throws Error if the pixel has no region or `phase` is not finite.
template <class Number>
void anchor_at(UnwrappedPhase<Number>& unwrapped, int column, int row, double phase);

/// The same for each region with a coarse absolute phase, rad, NaN where unknown, by the median
/// difference over the region. Throws Error if the sizes differ.
template <class Number>
void anchor_by(UnwrappedPhase<Number>& unwrapped, const Image<Number>& coarse);

}  // namespace slipstream
