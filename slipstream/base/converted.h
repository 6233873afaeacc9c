#pragma once

#include <algorithm>

#include "slipstream/base/image.h"

namespace slipstream {

/// The same picture in another type of number; into `to`, whose memory is used where it is of the
/// size.
template <class To, class From>
void convert(const Image<From>& from, Image<To>& to) {
  if (to.size() != from.size()) to = Image<To>(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [](From value) { return static_cast<To>(value); });
}

template <class To, class From>
Image<To> converted(const Image<From>& from) {
  Image<To> to;
  convert(from, to);
  return to;
}

}  // namespace slipstream
