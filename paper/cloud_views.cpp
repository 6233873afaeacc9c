#include "paper/cloud_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "geometry/triangulator.h"

namespace slipstream {
namespace {

/// Centre and scale of the views of a cloud.
struct Middle {
  double x = 0, y = 0, z = 0;
  double extent = 1;  ///< mm, of the wider of X and Y, without the outermost 0.5 %
};

Middle middle_of(const Cloud& cloud) {
  const auto sorted = [](const Image<float>& values) {
    std::vector<float> finite = finite_values(values);
    std::sort(finite.begin(), finite.end());
    return finite;
  };
  const std::vector<float> x = sorted(cloud.x), y = sorted(cloud.y), z = sorted(cloud.z);
  if (x.empty()) return {};

  const auto at = [](const std::vector<float>& values, double share) {
    return double{values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]};
  };
  const double width = at(x, 0.995) - at(x, 0.005), height = at(y, 0.995) - at(y, 0.005);
  return {(at(x, 0.995) + at(x, 0.005)) / 2, (at(y, 0.995) + at(y, 0.005)) / 2, at(z, 0.5),
          std::max(width, height)};
}

}  // namespace

Image<std::uint8_t> seen_turned(const Cloud& cloud, double degrees, Size picture) {
  const Middle middle = middle_of(cloud);
  const double scale = 0.9 * std::min(picture.width, picture.height) / middle.extent;
  const double angle = degrees * std::numbers::pi / 180;
  const double cosine = std::cos(angle), sine = std::sin(angle);

  // The texture's brightest 2 % are white.
  std::vector<float> lit;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (std::isfinite(cloud.z.begin()[i])) lit.push_back(cloud.intensity.begin()[i]);
  }
  std::sort(lit.begin(), lit.end());
  const double white = lit.empty() ? 1 : std::max(1.0F, lit[lit.size() * 98 / 100]);

  Image<std::uint8_t> seen(picture);
  Image<double> nearest(picture, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (!std::isfinite(cloud.z.begin()[i])) continue;
    const double x = cloud.x.begin()[i] - middle.x, z = cloud.z.begin()[i] - middle.z;
    const double across = cosine * x + sine * z, away = cosine * z - sine * x;
    const double column = picture.width / 2.0 + scale * across;
    const double row = picture.height / 2.0 + scale * (cloud.y.begin()[i] - middle.y);

    // A point is a square of 2 x 2 pixels; the nearer one hides the other.
    for (const auto& [right, down] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
      const int u = static_cast<int>(std::floor(column)) + right;
      const int v = static_cast<int>(std::floor(row)) + down;
      if (u < 0 || v < 0 || u >= picture.width || v >= picture.height) continue;
      if (away >= nearest(u, v)) continue;
      nearest(u, v) = away;
      seen(u, v) = grey_level(static_cast<float>(40 + 215 * cloud.intensity.begin()[i] / white));
    }
  }
  return seen;
}

Image<std::uint8_t> side_by_side(const std::vector<Image<std::uint8_t>>& pictures, int columns) {
  const Size one = pictures.front().size();
  const int count = static_cast<int>(pictures.size()), rows = (count + columns - 1) / columns;
  Image<std::uint8_t> all({columns * one.width, rows * one.height});
  for (int i = 0; i < count; ++i) {
    const int left = i % columns * one.width, top = i / columns * one.height;
    for_each_pixel_in_order(one, [&](int column, int row) {
      all(left + column, top + row) = pictures[static_cast<std::size_t>(i)](column, row);
    });
  }
  return all;
}

Image<std::uint8_t> as_picture(const Image<double>& grey_levels) {
  Image<std::uint8_t> picture(grey_levels.size());
  std::transform(grey_levels.begin(), grey_levels.end(), picture.begin(),
                 [](double value) { return grey_level(static_cast<float>(value)); });
  return picture;
}

Cloud cloud_of(const Scanner& scanner, const Image<double>& coordinate,
               const Image<double>& texture) {
  const Triangulator triangulate(scanner, Axis::x, PointMethod::form3);
  Cloud cloud(coordinate.size());
  for_each_pixel_in_order(coordinate.size(), [&](int column, int row) {
    const Eigen::Vector3d point = triangulate(column, row, coordinate(column, row));
    if (!point.allFinite()) return;
    cloud.x(column, row) = static_cast<float>(point.x());
    cloud.y(column, row) = static_cast<float>(point.y());
    cloud.z(column, row) = static_cast<float>(point.z());
    cloud.intensity(column, row) = static_cast<float>(texture(column, row));
    cloud.validity(column, row) = Validity::valid;
  });
  return cloud;
}

double median_depth_error(const Cloud& cloud, const Image<double>& depth) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    const double error = std::abs(cloud.z.begin()[i] - depth.begin()[i]);
    if (std::isfinite(error)) errors.push_back(error);
  }
  return errors.empty() ? std::nan("") : median(std::move(errors));
}

}  // namespace slipstream
