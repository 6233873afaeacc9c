#pragma once

#include "slipstream/image.h"

namespace slipstream {

/// Applies a moving mean of the window's odd width and height three times, in place: close to a
/// Gaussian with half of each as standard deviation. It removes anything periodic in the window's
/// width along rows or in its height along columns. At the edges the mean is over the pixels inside
/// the image. `scratch` is resized to the image.
void take_moving_mean(Image<float>& picture, Size window, Image<float>& scratch);

/// The nearest odd length.
int odd_length(double length);

}  // namespace slipstream
