#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "slipstream/geometry/lens.h"
#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// page.html, as it was when this was built.
std::string_view web_page();

/// Pixels that a page is sent at most: of larger pictures every second row and column, or third...
inline constexpr std::int64_t most_web_pixels = 1 << 20;

/// Rows and columns from one pixel that is sent to the next.
int web_step(Size camera);

/// The directions (u, v, 1) of the pixels that are sent, row by row: u and v as 32-bit floats,
/// little-endian. A point is at its depth times its direction.
std::string web_rays(const Lens& camera);

/// A cloud as the page takes it, little-endian: width, height, 1 where there is depth, else 0, and
/// the number of points of the whole cloud, each as 32-bit integer; the nearest depth and the step
/// of depth, mm, as 32-bit float; then for each pixel its depth in 16 bits, 0 where there is no
/// point, else steps from the nearest, plus 1; and its grey level in 8 bits. Without a scanner the
/// grey levels are those of the window's first frame. Behind it the phases, as PublishedRun tells
/// them, where there are any.
std::string web_cloud(const LiveCloud& cloud, const Image<std::uint8_t>& phase = {});

/// The numbers of a run's statistics in the text form of Prometheus: "slipstream_" and the names on
/// the way to each, counts that only grow as counters that end in "_total". Of a list of what has
/// names these are labels, of a list of numbers their places; of any other its length is told.
/// Throws Error for what is no JSON.
std::string metrics_of(std::string_view statistics);

}  // namespace slipstream
