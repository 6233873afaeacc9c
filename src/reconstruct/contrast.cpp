#include "reconstruct/contrast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "reconstruct/points.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

// Half the windows, pixels: in which a surface is compared with a plane, in which its slope is
// measured, and in which a correction must pay off.
constexpr int plane_half = 5, slope_half = 2, around_half = 3;

constexpr std::size_t sampled = 20'000;  // pixels are enough for a median or a mean

/// The valid pixels of a picture; all images have its size.
struct Surface {
  Image<float> coordinate;     ///< y, fields; 0 where invalid
  Image<float> weight;         ///< B^2, as noise of y falls with B; 0 where invalid
  Image<float> across, down;   ///< grad B / B along rows and columns, if significant
  Image<std::uint8_t> strong;  ///< 1 where grad B is significant
  double noise = 0;            ///< variance of B times the distance of y from a plane

  [[nodiscard]] bool is_valid(int column, int row) const { return weight(column, row) > 0; }
};

/// A plane at the middle of its window, from the middle pixel's value, and its slopes per pixel.
struct Plane {
  double above = 0, right = 0, down = 0;
};

/// The weighted plane through the pixels up to `half` away.
Plane plane_at(const Image<float>& values, const Image<float>& weights, int column, int row,
               int half) {
  // 1. Weighted sums; places and values are counted from the middle pixel.
  const float here = values(column, row);
  double total = 0, x = 0, y = 0, z = 0, xx = 0, yy = 0, xy = 0, xz = 0, yz = 0;
  const int first = std::max(-half, -column), last = std::min(half, values.width() - 1 - column);

  for (int j = std::max(-half, -row); j <= std::min(half, values.height() - 1 - row); ++j) {
    const float* const value = values.row(row + j) + column;
    const float* const weight = weights.row(row + j) + column;
    double line = 0, line_x = 0, line_xx = 0, line_z = 0, line_xz = 0;
    for (int i = first; i <= last; ++i) {
      const double w = weight[i], wz = w * (value[i] - here);
      line += w;
      line_x += w * i;
      line_xx += w * i * i;
      line_z += wz;
      line_xz += wz * i;
    }

    total += line;
    x += line_x;
    y += line * j;
    z += line_z;
    xx += line_xx;
    yy += line * j * j;
    xy += line_x * j;
    xz += line_xz;
    yz += line_z * j;
  }

  // 2. The slopes of least squares. Pixels in one line leave one slope open; it counts as small.
  const double mean_x = x / total, mean_y = y / total, mean_z = z / total;
  const double var_x = xx / total - mean_x * mean_x, var_y = yy / total - mean_y * mean_y;
  const double var_xy = xy / total - mean_x * mean_y;
  const double to_x = xz / total - mean_x * mean_z, to_y = yz / total - mean_y * mean_z;
  const double determinant =
      std::max(var_x * var_y - var_xy * var_xy, 1e-3 * var_x * var_y + 1e-12);

  Plane plane;
  plane.right = (to_x * var_y - to_y * var_xy) / determinant;
  plane.down = (to_y * var_x - to_x * var_xy) / determinant;
  plane.above = mean_z - plane.right * mean_x - plane.down * mean_y;
  return plane;
}

/// Distance of a pixel's value from the plane through those around it.
double roughness(const Image<float>& values, const Surface& surface, int column, int row) {
  return -plane_at(values, surface.weight, column, row, plane_half).above;
}

/// Calls `visit(column, row)` for about as many of the valid pixels inside a margin as are enough.
void for_each_sample(const Surface& surface, const auto& visit) {
  const auto& weight = surface.weight;
  const auto step = static_cast<int>(
      std::max(1.0, std::sqrt(static_cast<double>(weight.pixel_count()) / sampled)));
  for (int row = 2; row < weight.height() - 2; row += step) {
    for (int column = 2; column < weight.width() - 2; column += step) {
      if (surface.is_valid(column, row)) visit(column, row);
    }
  }
}

/// Standard deviation of a derivative of B by the five-point formula, from second differences; 0
/// without samples.
double derivative_noise(const Image<float>& modulation, const Surface& surface) {
  std::vector<double> bends;
  for_each_sample(surface, [&](int column, int row) {
    constexpr std::array bend{1.F, -2.F, 1.F};
    double sum = 0;
    for (int k = 0; k < 9; ++k) {
      sum += bend[k / 3] * bend[k % 3] * modulation(column + k % 3 - 1, row + k / 3 - 1);
    }
    if (std::isfinite(sum)) bends.push_back(std::abs(sum));
  });
  if (bends.empty()) return 0;

  // By the roots of the sums of the squared factors.
  const double of_derivative = std::sqrt(130.0) / 12, of_bend = 6;
  return of_derivative / of_bend * deviation_from_median(median(std::move(bends)));
}

/// Marks the pixels where the gradient of B is significant.
void find_gradients(const Image<float>& modulation, Surface& surface) {
  constexpr double least_gradient = 0.03;  // relative, per pixel
  constexpr double deviations = 4;         // of the gradient's noise
  const double noise = derivative_noise(modulation, surface);
  const auto [width, height] = modulation.size();

  for_each_pixel(modulation.size(), [&](int column, int row) {
    const bool is_inside = column >= 2 && row >= 2 && column < width - 2 && row < height - 2;
    if (!is_inside || !surface.is_valid(column, row)) return;

    const auto derivative = [&](int right, int down) {
      const auto at = [&](int k) { return double{modulation(column + k * right, row + k * down)}; };
      return (at(-2) - 8 * at(-1) + 8 * at(1) - at(2)) / 12;
    };
    const double across = derivative(1, 0), down = derivative(0, 1);
    const double here = modulation(column, row), steepness = std::hypot(across, down);
    if (!(steepness > deviations * noise && steepness > least_gradient * here)) return;

    surface.strong(column, row) = 1;
    surface.across(column, row) = static_cast<float>(across / here);
    surface.down(column, row) = static_cast<float>(down / here);
  });
}

/// The valid pixels, and where the gradient of their modulation is significant.
Surface surface_of(const Image<float>& coordinate, const Image<float>& modulation,
                   const Image<Validity>& validity) {
  const Size size = coordinate.size();
  Surface surface{.coordinate = Image<float>(size),
                  .weight = Image<float>(size),
                  .across = Image<float>(size),
                  .down = Image<float>(size),
                  .strong = Image<std::uint8_t>(size)};

  // 1. The valid pixels, and the gradients there.
  for_each_pixel(size, [&](int column, int row) {
    if (validity(column, row) != Validity::valid) return;
    surface.coordinate(column, row) = coordinate(column, row);
    surface.weight(column, row) = modulation(column, row) * modulation(column, row);
  });
  find_gradients(modulation, surface);

  // 2. The noise of y about a plane.
  std::vector<double> rough;
  for_each_sample(surface, [&](int column, int row) {
    const double residual = roughness(surface.coordinate, surface, column, row);
    rough.push_back(std::abs(residual) * modulation(column, row));
  });
  if (!rough.empty()) {
    surface.noise = std::pow(deviation_from_median(median(std::move(rough))), 2);
  }
  return surface;
}

/// The pull for a variance of 1 where gradients are significant, 0 elsewhere, from the slopes of
/// these coordinates.
Image<float> unit_pull(const Image<float>& coordinate, const Surface& surface) {
  Image<float> pull(coordinate.size());
  for_each_pixel(pull.size(), [&](int column, int row) {
    if (surface.strong(column, row) == 0) return;
    const Plane plane = plane_at(coordinate, surface.weight, column, row, slope_half);
    pull(column, row) = static_cast<float>(plane.right * surface.across(column, row) +
                                           plane.down * surface.down(column, row));
  });
  return pull;
}

/// The coordinates less the pull of a variance.
Image<float> corrected(const Image<float>& coordinate, double variance, const Image<float>& pull) {
  Image<float> result = coordinate;
  for (std::size_t i = 0; i < result.pixel_count(); ++i) {
    result.begin()[i] -= static_cast<float>(variance) * pull.begin()[i];
  }
  return result;
}

/// The variance of the blur by which the sharpest edges of print or light look as they do,
/// pixels^2; softer ones may be so on the surface. A surface that shades itself has edges that look
/// like a pull by far more blur.
double sharpest_blur(const Image<float>& modulation, const Surface& surface) {
  constexpr double least_change = 0.3;  // of the brighter side
  constexpr double one_way = 0.9;       // of the difference between the brightest and darkest
  constexpr double sharp = 0.97;        // quantile
  constexpr std::size_t fewest = 50;
  constexpr double largest = 2;  // pixels^2

  // 1. How much of the change over six pixels the middle two have.
  std::vector<double> shares;
  for (int row = 3; row < modulation.height() - 3; ++row) {
    for (int column = 3; column < modulation.width() - 3; ++column) {
      if (surface.strong(column, row) == 0) continue;
      const bool is_upright =
          std::abs(surface.across(column, row)) > std::abs(surface.down(column, row));
      const auto at = [&](int k) {
        return double{is_upright ? modulation(column + k, row) : modulation(column, row + k)};
      };
      double least = at(0), most = at(0);
      for (int k = -3; k <= 3; ++k) {
        least = std::min(least, at(k));
        most = std::max(most, at(k));
      }

      // A line has the same level on both sides.
      const double change = std::abs(at(3) - at(-3));
      if (!(change > least_change * most && change > one_way * (most - least))) continue;
      shares.push_back(std::abs(at(1) - at(-1)) / change);
    }
  }
  if (shares.size() < fewest) return largest;
  const double share = quantile(shares, sharp);

  // 2. A step blurred by a Gaussian of deviation s has erf(1 / (s sqrt 2)) of its change there.
  double s2 = 1.0 / 12;
  while (s2 < largest && std::erf(1 / std::sqrt(2 * s2)) > share) s2 *= 1.02;
  return s2;
}

/// A variance, and by how much it lowers the mean cost of the distances from a plane.
struct BestVariance {
  double variance = 0, gain = 0;
};

/// The variance, up to the largest, whose correction leaves the smoothest surface; large distances
/// count little.
BestVariance best_variance(const Surface& surface, const Image<float>& pull, double largest) {
  constexpr int variances = 101;
  constexpr double large = 9;  // square of a distance, in those by noise

  // 1. The distances from a plane at some of the strong pixels, and their change by a pull.
  std::vector<std::array<int, 2>> strong;
  for (int row = 0; row < pull.height(); ++row) {
    for (int column = 0; column < pull.width(); ++column) {
      if (surface.strong(column, row) != 0) strong.push_back({column, row});
    }
  }
  const std::size_t step = strong.size() / sampled + 1;
  struct Distance {
    double before, by_pull;
  };
  std::vector<Distance> distances;
  for (std::size_t i = 0; i < strong.size(); i += step) {
    const auto [column, row] = strong[i];
    const double modulation = std::sqrt(surface.weight(column, row));
    distances.push_back({.before = modulation * roughness(surface.coordinate, surface, column, row),
                         .by_pull = modulation * roughness(pull, surface, column, row)});
  }
  if (distances.empty() || !(surface.noise > 0)) return {};

  // 2. The least cost.
  BestVariance best;
  double least = 0, without = 0;
  for (int i = 0; i < variances; ++i) {
    const double variance = largest * i / (variances - 1);
    double cost = 0;
    for (const auto& [before, by_pull] : distances) {
      const double after = before - variance * by_pull;
      cost += std::log1p(after * after / (large * surface.noise));
    }
    cost /= static_cast<double>(distances.size());

    if (i == 0) without = least = cost;
    if (cost < least) {
      least = cost;
      best = {variance, without - cost};
    }
  }
  return best;
}

/// Sum over the pixels up to `half` away, inside the picture.
double sum_around(const Image<float>& values, int column, int row, int half) {
  double sum = 0;
  for (int y = std::max(row - half, 0); y <= std::min(row + half, values.height() - 1); ++y) {
    for (int x = std::max(column - half, 0); x <= std::min(column + half, values.width() - 1);
         ++x) {
      sum += values(x, y);
    }
  }
  return sum;
}

/// 1 at pixels up to around_half from a strong one.
Image<std::uint8_t> near_strong(const Image<std::uint8_t>& strong) {
  Image<std::uint8_t> near(strong.size());
  for (int row = 0; row < strong.height(); ++row) {
    for (int column = 0; column < strong.width(); ++column) {
      if (strong(column, row) == 0) continue;
      for (int y = std::max(row - around_half, 0);
           y <= std::min(row + around_half, strong.height() - 1); ++y) {
        const int first = std::max(column - around_half, 0);
        const int last = std::min(column + around_half, strong.width() - 1);
        std::fill(near.row(y) + first, near.row(y) + last + 1, std::uint8_t{1});
      }
    }
  }
  return near;
}

/// Scales the pull of a variance of 1 to this one; at steps, and if the surroundings would not
/// become smoother, it is 0.
void keep_improvements(const Surface& surface, double variance, Image<float>& pull) {
  constexpr double roughest = 9;  // largest mean square of a corrected surface, in the noise's
  constexpr double most = 100;    // largest square of one pixel: a wrong fringe order counts little

  // 1. The squared distances from a plane, weighted, before and after.
  const Size size = pull.size();
  const Image<std::uint8_t> near = near_strong(surface.strong);
  Image<float> before(size), after(size), valid(size);
  for_each_pixel(size, [&](int column, int row) {
    if (near(column, row) == 0 || !surface.is_valid(column, row)) return;
    const double was = roughness(surface.coordinate, surface, column, row);
    const double is = was - variance * roughness(pull, surface, column, row);

    const auto limited = [&](double distance) {
      const double square = surface.weight(column, row) * distance * distance;
      return static_cast<float>(std::min(square, most * surface.noise));
    };
    before(column, row) = limited(was);
    after(column, row) = limited(is);
    valid(column, row) = 1;
  });

  // 2. Their sums around each pixel.
  for_each_pixel(size, [&](int column, int row) {
    if (surface.strong(column, row) == 0) return;
    const auto around = [&](const Image<float>& values) {
      return sum_around(values, column, row, around_half);
    };
    const double rest = around(after);
    const bool is_better = rest < around(before) && rest < roughest * surface.noise * around(valid);
    pull(column, row) *= is_better ? static_cast<float>(variance) : 0.F;
  });
}

/// The point on the same ray whose coordinate is greater by this little.
Eigen::Vector3d moved_by(double change, const Eigen::Vector3d& point, const EngineSetup& setup) {
  constexpr double step = 1e-6;  // of the distance, for the slope
  constexpr int rounds = 3;      // of Newton's method, which reach the rounding of a float
  const auto y = [&](double distance) { return coordinate_of(distance * point, setup); };
  const double slope = (y(1 + step) - y(1 - step)) / (2 * step), wanted = y(1) + change;

  double distance = 1;
  for (int round = 0; round < rounds; ++round) distance += (wanted - y(distance)) / slope;
  return distance * point;
}

}  // namespace

ContrastPull contrast_pull(const Image<float>& coordinate, const Image<float>& modulation,
                           const Image<Validity>& validity) {
  constexpr double least_gain = 0.0125;  // of the mean cost
  const Surface surface = surface_of(coordinate, modulation, validity);

  // 1. The variance; the slopes are measured again on the surface that it leaves.
  const double largest = sharpest_blur(modulation, surface);
  Image<float> pull = unit_pull(surface.coordinate, surface);
  BestVariance best = best_variance(surface, pull, largest);
  if (best.variance > 0) {
    pull = unit_pull(corrected(surface.coordinate, best.variance, pull), surface);
    best = best_variance(surface, pull, largest);
  }
  if (best.gain < least_gain) return {.pull = Image<float>(coordinate.size())};

  // 2. The pixels that it makes better.
  keep_improvements(surface, best.variance, pull);
  return {.variance = best.variance, .pull = std::move(pull)};
}

void require_contrast_correctable(const EngineSetup& setup) {
  throw_if(setup.sequence.strategy.layout().unwrapping->whole_stripes,
           "`correct_contrast` needs phases, which {} does not measure",
           setup.sequence.strategy.name());
}

void correct_contrast(const EngineSetup& setup, Cloud& cloud, Maps& maps) {
  throw_if(maps.coordinate.size() != cloud.size() || maps.modulation.size() != cloud.size(),
           "`correct_contrast` needs coordinates and modulation of the cloud's size");
  maps.contrast = contrast_pull(maps.coordinate, maps.modulation, cloud.validity).pull;

  for_each_pixel(cloud.size(), [&](int column, int row) {
    const float pull = maps.contrast(column, row);
    if (pull == 0) return;
    float& coordinate = maps.coordinate(column, row);
    coordinate -= pull;

    const Eigen::Vector3d point = moved_by(-pull, position_at(cloud, column, row), setup);
    const Validity validity = validity_of(coordinate, point, setup);
    if (validity != Validity::valid) return cloud.reject(column, row, validity);

    const Eigen::Vector3f narrow = point.cast<float>();
    cloud.x(column, row) = narrow.x();
    cloud.y(column, row) = narrow.y();
    cloud.z(column, row) = narrow.z();
  });
}

}  // namespace slipstream
