#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "slipstream/base/size.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/lens_choice.h"

namespace slipstream {

/// The residuals of one device: one list of distances (seen minus predicted, pixels) for each view.
using Residuals = std::vector<std::vector<Eigen::Vector2d>>;

/// A PNG of a device's picture: which parts how many boards covered, and at each corner its
/// residual as an arrow, much enlarged; the length of a tenth of a pixel or so is drawn below.
void write_residual_map(const std::filesystem::path& path, const std::vector<BoardView>& views,
                        const Residuals& residuals, Device device, Size size);

/// A PNG with every residual as a point, x against y, a colour for each pose.
void write_residual_scatter(const std::filesystem::path& path, const std::vector<BoardView>& views,
                            const Residuals& residuals);

}  // namespace slipstream
