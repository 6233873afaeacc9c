#include "calibrate/projector_corners.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"

namespace slipstream {
namespace {

using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

/// A camera pixel near a corner and the projector pixel that lights it.
struct Sample {
  Eigen::Vector2d camera;     ///< from the corner, in radii
  Eigen::Vector2d projector;  ///< pixels, from `Neighbourhood::middle`
  double weight = 0;
};

struct Neighbourhood {
  std::vector<Sample> samples;
  Eigen::Vector2d middle;  ///< median projector pixel
  int pixels = 0;          ///< reliable or not
};

Neighbourhood neighbourhood(const ProjectorMap& map, const Eigen::Vector2d& corner, double radius) {
  Neighbourhood result;

  // The part of the square around the corner that is inside the picture.
  const int left = std::max(0, static_cast<int>(std::ceil(corner.x() - radius)));
  const int right = std::min(map.x.width() - 1, static_cast<int>(std::floor(corner.x() + radius)));
  const int top = std::max(0, static_cast<int>(std::ceil(corner.y() - radius)));
  const int bottom =
      std::min(map.x.height() - 1, static_cast<int>(std::floor(corner.y() + radius)));

  std::vector<double> x, y;
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      const Eigen::Vector2d offset = (Eigen::Vector2d(column, row) - corner) / radius;
      if (offset.squaredNorm() > 1) continue;
      ++result.pixels;

      const double weight = map.weight(column, row);
      if (weight <= 0) continue;

      result.samples.push_back({offset, {map.x(column, row), map.y(column, row)}, weight});
      x.push_back(map.x(column, row));
      y.push_back(map.y(column, row));
    }
  }

  // Coordinates relative to the median keep the linear equations well conditioned.
  if (result.samples.empty()) return result;
  result.middle = {median(std::move(x)), median(std::move(y))};
  for (Sample& sample : result.samples) sample.projector -= result.middle;
  return result;
}

/// The homography [h0 h1 h2; h3 h4 h5; h6 h7 1] at a point.
Eigen::Vector2d at(const Vector8& h, const Eigen::Vector2d& point) {
  const Eigen::Vector3d p = point.homogeneous();
  return Eigen::Vector2d(h.segment<3>(0).dot(p), h.segment<3>(3).dot(p)) /
         (h.tail<2>().dot(point) + 1);
}

/// Linear least squares for h with the weights times `factors`; not finite if undetermined.
Vector8 fitted(const std::vector<Sample>& samples, const std::vector<double>& factors) {
  Matrix8 normal = Matrix8::Zero();
  Vector8 right = Vector8::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& [camera, projector, weight] = samples[i];

    // x (h6 u + h7 v + 1) = h0 u + h1 v + h2, and the same for y: linear in h.
    Vector8 row_x = Vector8::Zero(), row_y = Vector8::Zero();
    row_x.segment<3>(0) = camera.homogeneous();
    row_y.segment<3>(3) = camera.homogeneous();
    row_x.tail<2>() = -projector.x() * camera;
    row_y.tail<2>() = -projector.y() * camera;

    const double w = weight * factors[i];
    normal += w * (row_x * row_x.transpose() + row_y * row_y.transpose());
    right += w * (projector.x() * row_x + projector.y() * row_y);
  }

  return solve_symmetric(normal, right);
}

/// Initial factors: 0 for pixels off by whole fringes (far from the median), 1 for the others.
std::vector<double> starting_factors(const std::vector<Sample>& samples) {
  std::vector<double> distances;
  for (const Sample& sample : samples) distances.push_back(sample.projector.norm());

  // Four median distances, at least 2 pixels.
  const double reach = std::max(4 * median(distances), 2.0);

  std::vector<double> factors;
  for (const double distance : distances) factors.push_back(distance < reach ? 1 : 0);
  return factors;
}

ProjectorCorner projector_corner(const ProjectorMap& map, const Eigen::Vector2d& corner,
                                 double radius) {
  constexpr double least_share = 0.3;  // of the pixels around the corner
  constexpr std::size_t fewest_samples = 24;
  constexpr int rounds = 5;

  const Neighbourhood about = neighbourhood(map, corner, radius);
  const std::vector<Sample>& samples = about.samples;
  const bool enough = samples.size() >= fewest_samples &&
                      static_cast<double>(samples.size()) >= least_share * about.pixels;
  const ProjectorCorner none{{nan, nan}, Eigen::Matrix2d::Constant(nan)};
  if (!enough) return none;

  // Iteratively reweighted least squares.
  std::vector<double> factors = starting_factors(samples);
  std::vector<double> residuals(samples.size());
  Vector8 h = Vector8::Zero();
  for (int round = 0; round < rounds; ++round) {
    h = fitted(samples, factors);
    if (!h.allFinite()) return none;

    for (std::size_t i = 0; i < samples.size(); ++i) {
      residuals[i] = (at(h, samples[i].camera) - samples[i].projector).norm();
    }

    const double deviation = std::max(median(residuals) / 1.1774, 1e-9);  // of a Rayleigh variable
    for (std::size_t i = 0; i < samples.size(); ++i) {
      factors[i] = tukey_weight(residuals[i] / deviation);
    }
  }

  Eigen::Matrix2d slope;  // of the homography at the corner
  slope << h[0] - h[2] * h[6], h[1] - h[2] * h[7], h[3] - h[5] * h[6], h[4] - h[5] * h[7];
  return {at(h, Eigen::Vector2d::Zero()) + about.middle, slope / radius};
}

}  // namespace

double distance_to_next(const PixelPlaces& corners, std::size_t i) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < corners.size(); ++j) {
    if (j != i) least = std::min(least, (corners[i] - corners[j]).norm());
  }
  return least;
}

ProjectorMap projector_map(const FrameViews& frames_x, const BasicMaps<double>& along_x,
                           const FrameViews& frames_y, const BasicMaps<double>& along_y,
                           Size projector, double minimum_modulation) {
  const Size size = frames_x.size();
  ProjectorMap map{Image<double>(size), Image<double>(size), Image<double>(size)};

  const Image<std::uint8_t> saturated_x = saturation_mask(frames_x);
  const Image<std::uint8_t> saturated_y = saturation_mask(frames_y);
  const double grey_level_x = frames_x.full_scale() / 255;
  const double grey_level_y = frames_y.full_scale() / 255;

  for_each_pixel(size, [&](int column, int row) {
    map.x(column, row) = along_x.coordinate(column, row) * projector.width;
    map.y(column, row) = along_y.coordinate(column, row) * projector.height;

    const double modulation = std::min(along_x.modulation(column, row) / grey_level_x,
                                       along_y.modulation(column, row) / grey_level_y);

    const bool reliable = modulation >= minimum_modulation && saturated_x(column, row) == 0 &&
                          saturated_y(column, row) == 0;
    map.weight(column, row) = reliable ? modulation * modulation : 0;
  });

  return map;
}

std::vector<ProjectorCorner> projector_corners(const ProjectorMap& map, const PixelPlaces& corners,
                                               double share) {
  std::vector<ProjectorCorner> result(corners.size());
  for_each_row(static_cast<int>(corners.size()), [&](int corner) {
    constexpr double least_radius = 4;  // pixels
    const double radius = std::max(share * distance_to_next(corners, corner), least_radius);
    result[corner] = projector_corner(map, corners[corner], radius);
  });
  return result;
}

}  // namespace slipstream
