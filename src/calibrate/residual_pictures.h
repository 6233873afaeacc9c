#pragma once

#include <vector>

#include "calibrate/board_view.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// One device's residuals for each view.
using Residuals = std::vector<PixelPlaces>;

/// A device's picture with the coverage by `boards` as shading and the residuals of `views` as
/// enlarged arrows; a scale bar is drawn below.
Image<Colour> residual_map(const BoardViews& boards, const BoardViews& views,
                           const Residuals& residuals, Device device, Size size);

/// Scatter plot of the residuals, y over x, one colour for each pose.
Image<Colour> residual_scatter(const BoardViews& views, const Residuals& residuals);

/// The residual map of a device as arrows on a grid, over the coverage.
Image<Colour> drawn_residual(const BoardViews& boards, const Lens& lens, Device device);

}  // namespace slipstream
