#pragma once

#include <string_view>
#include <vector>

#include "slipstream/scanner.h"

namespace slipstream {

/// Number of terms of a residual of that degree.
constexpr int residual_term_count(int degree) {
  return (degree + 1) * (degree + 2) / 2;
}

/// Throws Error, beginning with the device, unless the terms are finite and all those of a degree
/// up to the largest.
void require_valid(const LensResidual& residual, std::string_view device);

/// The pixel that a residual makes of pixel `ideal` of the lens model.
Eigen::Vector2d shifted_by(const LensResidual& residual, const Eigen::Vector2d& ideal);

/// The residual for pictures that are `factor` times as large.
LensResidual scaled(LensResidual residual, double factor);

/// One equation for a residual: at `pixel`, its component along the unit vector `along` is `off`.
struct ResidualSample {
  Eigen::Vector2d pixel, along;
  double off = 0;  ///< pixels
};

/// The residual of a degree that fits the samples best, by least squares without the samples
/// farther off than three standard deviations. It is small where the picture has no samples, and
/// across their directions.
LensResidual fitted_residual(const std::vector<ResidualSample>& samples, Size picture, int degree);

}  // namespace slipstream
