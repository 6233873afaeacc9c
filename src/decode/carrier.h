#pragma once

#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// A sinusoid's position in an image's spectrum: cycles per pixel along rows and columns.
struct Carrier {
  double right = 0, down = 0;
};

/// Finds the carriers of a pattern with the given periods across the projector's field, along the
/// image's rows or columns, in an image of 0.4 to 2.5 times the field: the common scale at which
/// they are strongest, then each refined. Always returns a result.
std::vector<Carrier> found_carriers(const Image<float>& picture, const std::vector<double>& periods,
                                    bool along_rows);

}  // namespace slipstream
