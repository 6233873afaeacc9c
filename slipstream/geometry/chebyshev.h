#pragma once

#include <Eigen/Core>

namespace slipstream {

/// Row k: the coefficients of the Chebyshev polynomial T_k in ascending powers, k < count.
template <int count>
Eigen::Matrix<double, count, count> chebyshev_coefficients() {
  Eigen::Matrix<double, count, count> T = Eigen::Matrix<double, count, count>::Zero();
  T(0, 0) = T(1, 1) = 1;
  for (int k = 2; k < count; ++k) {
    T.row(k).tail(count - 1) = 2 * T.row(k - 1).head(count - 1);
    T.row(k) -= T.row(k - 2);
  }
  return T;
}

}  // namespace slipstream
