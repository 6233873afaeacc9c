#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "slipstream/live_pipeline.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// page.html with its style and scripts inside, embedded at build time.
std::string_view web_page();

/// The page's content security policy: only its own scripts and styles, no other sources, no
/// framing by other pages.
inline constexpr const char* page_rules =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The colours of depths, red, green and blue in 8 bits.
std::string web_palette();

/// Step in rows and columns between transmitted pixels, so that at most 2^20 are sent.
int web_step(Size camera);

/// Directions (u, v, 1) of the transmitted pixels, row by row: u, v as floats. Points are depth *
/// direction.
std::string web_rays(const Lens& camera);

/// A cloud for the page, little-endian. 32-bit integers: width, height, contents (1 depth, 2
/// colours, 3 both), points in the whole cloud; 32-bit floats: nearest depth and depth step, mm;
/// then all depths in 16 bits, 0 if invalid, else steps from the nearest plus 1; all grey levels in
/// 8 bits, without a scanner those of the window's first frame; all colours, if any, as red, green
/// and blue bytes, sRGB; and the phases of PublishedRun, if any.
std::string web_cloud(const LiveCloud& cloud, const Image<std::uint8_t>& phase = {});

/// A run's statistics in Prometheus text format: "slipstream_" and the JSON path of each number;
/// counters end in "_total". Labels are the names in a list of named objects and the indices in a
/// list of numbers; other lists give their length. Throws Error if the text is not JSON.
std::string metrics_of(std::string_view statistics);

}  // namespace slipstream
