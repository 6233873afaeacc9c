#pragma once

namespace slipstream {

/// A number as the kernels take it, in single precision.
inline float narrow(double value) {
  return static_cast<float>(value);
}

}  // namespace slipstream
