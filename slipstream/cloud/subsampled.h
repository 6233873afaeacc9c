#pragma once

#include "slipstream/base/image.h"
#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// Every `step`-th pixel of every `step`-th row, from the first on; step 1 or more. No value is
/// mixed with another.
template <class Pixel>
Image<Pixel> subsampled(const Image<Pixel>& image, int step) {
  Image<Pixel> sparse({(image.width() + step - 1) / step, (image.height() + step - 1) / step});
  for (int row = 0; row < sparse.height(); ++row) {
    for (int column = 0; column < sparse.width(); ++column) {
      sparse(column, row) = image(step * column, step * row);
    }
  }
  return sparse;
}

/// Likewise, an organised cloud of a coarser grid.
inline Cloud subsampled(const Cloud& cloud, int step) {
  Cloud sparse;
  sparse.x = subsampled(cloud.x, step);
  sparse.y = subsampled(cloud.y, step);
  sparse.z = subsampled(cloud.z, step);
  sparse.intensity = subsampled(cloud.intensity, step);
  sparse.validity = subsampled(cloud.validity, step);
  return sparse;
}

}  // namespace slipstream
