#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/lens_choice.h"

namespace slipstream {

/// How many boards cover each of the cells into which a device's picture is divided, 100 of
/// them across. Only the hull of a board's corners counts.
Image<std::uint8_t> coverage_map(const std::vector<BoardView>& views, Device device, Size size);

/// Share of the cells that some board covers.
double covered_share(const Image<std::uint8_t>& coverage);

}  // namespace slipstream
