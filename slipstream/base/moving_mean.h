#pragma once

#include "slipstream/base/image.h"

namespace slipstream {

/// Three times the mean over a window around each pixel, of odd width and height: near to a
/// Gaussian of half of them as standard deviations, and nothing passes of what repeats after its
/// width along rows or its height along columns. Beyond the edges there is nothing: means are over
/// what there is. In place; `scratch` takes the picture's size.
void take_moving_mean(Image<float>& picture, Size window, Image<float>& scratch);

/// The odd length next to one.
int odd_length(double length);

}  // namespace slipstream
