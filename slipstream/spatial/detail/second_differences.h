#pragma once

#include "slipstream/image/image.h"

namespace slipstream {

/// How far the phase of each pixel is from the mean of its neighbours on both sides, the wrapped
/// differences in periods squared: the mean along row, column and diagonals, of those that are
/// there. Where none is: the most that can be.
Image<float> second_differences(const Image<float>& cycles);

}  // namespace slipstream
