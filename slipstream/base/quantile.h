#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// The value that has a share of the others below it, 0 for the least to 1 for the greatest; of two
/// that are as near the greater. The values, at least one and none of them NaN, are put in another
/// order.
template <class Number>
Number quantile(std::vector<Number>& values, double share) {
  const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The values of a picture that are finite, of every `step`-th pixel.
template <class Number>
std::vector<Number> finite_values(const Image<Number>& image, std::size_t step = 1) {
  std::vector<Number> finite;
  for (std::size_t i = 0; i < image.pixel_count(); i += step) {
    if (std::isfinite(image.begin()[i])) finite.push_back(image.begin()[i]);
  }
  return finite;
}

}  // namespace slipstream
