#pragma once

#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// Where a sinusoid stands in the spectrum of a picture: cycles per pixel along its rows and
/// columns.
struct Carrier {
  double right = 0, down = 0;
};

/// The carriers of a pattern of so many periods each across the projector's field, all along the
/// picture's rows or all along its columns, in a picture that sees between 0.4 and 2.5 times the
/// field: those scaled alike that are strongest, and then each as far as it leans and differs.
/// Whatever the picture, there is an answer.
std::vector<Carrier> found_carriers(const Image<float>& picture, const std::vector<double>& periods,
                                    bool along_rows);

}  // namespace slipstream
