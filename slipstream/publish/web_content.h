#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "slipstream/geometry/scanner.h"
#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// page.html, as it was when this was built.
std::string_view web_page();

/// Rows and columns from one pixel that is sent to the next, so that there are 2^20 at most.
int web_step(Size camera);

/// Directions (u, v, 1) of the pixels sent, row by row: u, v as floats. Points: depth * direction.
std::string web_rays(const Lens& camera);

/// A cloud for the page, little-endian. 32-bit integers: width, height, 1 with depth, else 0,
/// points of the whole cloud; 32-bit floats: nearest depth and step of depth, mm; then all depths
/// in 16 bits, 0 without a point, else steps from the nearest, plus 1; all grey levels in 8 bits,
/// without a scanner of the window's first frame; and the phases of PublishedRun, if there are any.
std::string web_cloud(const LiveCloud& cloud, const Image<std::uint8_t>& phase = {});

/// The numbers of a run's statistics in the text form of Prometheus: "slipstream_" and the names on
/// the way to each; counts that only grow end in "_total". Labels are the names in a list of what
/// has names, the places in a list of numbers; others give their length. Throws Error if not JSON.
std::string metrics_of(std::string_view statistics);

}  // namespace slipstream
