#pragma once

#include "slipstream/image/image.h"

namespace slipstream {

/// How far a depth is from the nearest of the surfaces, `depth`, that a pixel and its eight
/// neighbours see, since a lens mixes those: mm, with its sign; infinite where there is none.
double nearest_error(double z, const Image<double>& depth, int column, int row);

}  // namespace slipstream
