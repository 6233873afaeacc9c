#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// A cloud's points in their texture, seen from far away: from the camera's side, or turned by that
/// many degrees about the vertical axis through the middle of the cloud; 90: from its side.
/// Pixels without a point are black. All views of one cloud have one scale.
Image<std::uint8_t> seen_turned(const Cloud& cloud, double degrees, Size picture = {320, 320});

/// Pictures of one size row by row, `columns` in a row.
Image<std::uint8_t> side_by_side(const std::vector<Image<std::uint8_t>>& pictures, int columns);

/// A map of grey levels as a picture, rounded and clipped.
Image<std::uint8_t> as_picture(const Image<double>& grey_levels);

/// Triangulates projector coordinates with a texture in grey levels; NaN gives no point.
Cloud cloud_of(const Scanner& scanner, const Image<double>& coordinate,
               const Image<double>& texture);

/// Median of the depth errors, mm, without sign, over the valid points with a true depth.
double median_depth_error(const Cloud& cloud, const Image<double>& depth);

}  // namespace slipstream
