#pragma once

#include <filesystem>
#include <string>

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// The values that a preview's colours span.
struct ValueRange {
  double low = 0;
  double high = 1;
};

/// From the 1st to the 99th percentile of the finite values, a little wider, so that a few outliers
/// do not take all the colours. [0, 1] where nothing is finite.
ValueRange robust_range(const Image<double>& map);

/// A PNG for people: depth in colours, shaded by the surface's slope so that its form shows, with a
/// scale in millimetres beside it. Pixels without a point are dark grey. Sides longer than 1000
/// pixels are reduced.
void write_depth_preview(const std::filesystem::path& path, const Cloud& cloud);

/// The same of a map, unshaded, with `unit` printed over the scale; small maps are enlarged.
void write_map_preview(const std::filesystem::path& path, const Image<double>& map,
                       const std::string& unit);

}  // namespace slipstream
