#include "slipstream/reconstruct/detail/epipolar_line.h"

#include <array>

#include "slipstream/base/numbers.h"

namespace slipstream {
namespace {

/// Weights of the four pixels around a place `t` past the second of them: cubic convolution (Keys).
std::array<double, 4> cubic_weights(double t) {
  const double u = 1 - t;
  return {-0.5 * t * u * u, 1 + t * t * (1.5 * t - 2.5), 1 + u * u * (1.5 * u - 2.5),
          -0.5 * u * t * t};
}

}  // namespace

Stereo::Stereo(const Scanner& first, const Scanner& second)
    : rotation(second.rotation.transpose() * first.rotation),
      translation(second.rotation.transpose() * (first.translation - second.translation)) {}

Eigen::Vector2d EpipolarLine::pixel(double depth) const {
  const Eigen::Vector3d point = stereo_.rotation * (depth * ray_) + stereo_.translation;
  if (!(point.z() > 0)) return {nan, nan};
  return project(camera_, point);
}

double EpipolarLine::difference(const Image<Phasor>& phase, Phasor reference, double depth) const {
  const Eigen::Vector2d place = pixel(depth);
  if (!(place.x() >= 1 && place.y() >= 1 && place.x() < phase.width() - 2 &&
        place.y() < phase.height() - 2)) {
    return nan;
  }
  const int left = static_cast<int>(place.x()), top = static_cast<int>(place.y());
  const auto valid = [&](int column, int row) {
    return seen_.validity(column, row) == Validity::valid;
  };
  if (!valid(left, top) || !valid(left + 1, top) || !valid(left, top + 1) ||
      !valid(left + 1, top + 1)) {
    return nan;
  }
  const auto across = cubic_weights(place.x() - left), down = cubic_weights(place.y() - top);
  Phasor sum = 0;
  for (int j = 0; j < 4; ++j) {
    const Phasor* row = phase.row(top - 1 + j) + left - 1;
    sum += down[static_cast<std::size_t>(j)] *
           (across[0] * row[0] + across[1] * row[1] + across[2] * row[2] + across[3] * row[3]);
  }
  return std::arg(sum * std::conj(reference));
}

double EpipolarLine::depth_of_a_pixel(double depth) const {
  const double step = 1e-3 * depth;
  return step / (pixel(depth + step) - pixel(depth)).norm();
}

}  // namespace slipstream
