#include "reconstruct/edge_sigma.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Core>

namespace slipstream {
namespace {

/// A pixel's neighbours, as far as they tell where its light comes from.
struct Surroundings {
  bool at_step = false;   ///< beside another surface, or one that was cleaned away
  bool at_unlit = false;  ///< beside a pixel without light: a shadow, a dark print, no surface
  Eigen::Vector2d away = Eigen::Vector2d::Zero();  ///< sum of the directions from unlit pixels
  std::array<double, 9> change{};  ///< of the coordinate, to each neighbour on the surface; else 0
  double brightest = 0;            ///< modulation of the surface
  double across = 0;               ///< distance between pixels, mm
};

constexpr double steep = EdgeModel::steep, deviations = EdgeModel::deviations;
constexpr double off_centre = EdgeModel::off_centre, by_lens = EdgeModel::by_lens;

// Across larger steps, in distances between pixels, a mixture of both surfaces would lack
// modulation, and be rejected.
constexpr double largest = 20;

/// Direction from a pixel to neighbour `i` of 0 to 8; 4 is itself.
Eigen::Vector2d to_neighbour(int i) {
  return {i % 3 - 1, i / 3 - 1};
}

/// Distances to the neighbours, pixels.
constexpr double diagonal = std::numbers::sqrt2;
constexpr std::array distance_to{diagonal, 1.0, diagonal, 1.0, 0.0, 1.0, diagonal, 1.0, diagonal};

bool is_unlit(Validity validity) {
  return validity == Validity::too_dark || validity == Validity::doubtful_order ||
         validity == Validity::no_point || validity == Validity::outside_field;
}

/// Whether a pixel was measured and found to be off its surface.
bool is_off_surface(Validity validity) {
  return validity == Validity::mixed || validity == Validity::outlier ||
         validity == Validity::small_component;
}

/// `depth_by_y`: change of the depth with the coordinate, mm per field; `noise`: standard deviation
/// of the coordinate.
Surroundings surroundings(const Cloud& cloud, const Maps& maps, int column, int row,
                          double depth_by_y, double noise) {
  const Eigen::Vector3d here = position_at(cloud, column, row);
  Surroundings around{.brightest = maps.modulation(column, row)};
  std::array<double, 9> unseen{};  // changes to lit neighbours without a point

  for (int i = 0; i < 9; ++i) {
    const int x = column + i % 3 - 1, y = row + i / 3 - 1;
    if (i == 4 || x < 0 || y < 0 || x >= cloud.size().width || y >= cloud.size().height) continue;

    const double change = std::abs(maps.coordinate(x, y) - maps.coordinate(column, row));
    const Validity validity = cloud.validity(x, y);
    if (is_unlit(validity)) {
      around.at_unlit = true;
      around.away -= to_neighbour(i);
    } else if (validity != Validity::valid) {
      around.at_step |= is_off_surface(validity);
      unseen[i] = change;
    } else {
      const Eigen::Vector3d there = position_at(cloud, x, y);
      const double across = distance_between_rays(here, there);
      const double step = std::abs(there.z() - here.z());

      if (!(step <= steep * across)) {
        around.at_step |= !((there - here).norm() < deviations * noise * depth_by_y);
      }
      if (!(step <= largest * across)) continue;

      around.change[i] = std::max(change, step / depth_by_y);
      around.brightest = std::max(around.brightest, double{maps.modulation(x, y)});
      around.across = std::max(around.across, across / distance_to[i]);
    }
  }

  // Saturated pixels, and those outside of a region, have no point but a coordinate: it shows
  // whether the surface continues. A frontal one changes it by less than one distance.
  const double limit = (steep + 1) * around.across / depth_by_y;
  for (int i = 0; i < 9; ++i) {
    around.at_step |= !(unseen[i] <= limit * distance_to[i] + deviations * noise);
  }

  return around;
}

/// Change of the coordinate over a pixel, at most, along a direction of the picture and 45 degrees
/// beside it; in all directions without a change there.
double change_along(const Surroundings& around, const Eigen::Vector2d& direction) {
  constexpr double beside = 0.7;
  double along = 0, all = 0;

  for (int i = 0; i < 9; ++i) {
    if (around.change[i] == 0) continue;
    const Eigen::Vector2d to = to_neighbour(i);
    const double change = around.change[i] / distance_to[i];
    all = std::max(all, change);
    if (std::abs(to.dot(direction)) >= beside * distance_to[i]) along = std::max(along, change);
  }

  return along > 0 ? along : all;
}

/// By how much contrast still pulls a pixel's coordinate, fields: towards the brighter side of the
/// pixel. Uncorrected that is s^2 (grad B / B) . grad y, with the variance s^2 of the places that
/// it mixes.
double pull_of_contrast(const Cloud& cloud, const Maps& maps, int column, int row) {
  // Where a pull was taken from the coordinate, a share of it is left. The errors of virtual
  // chessboards beyond their noise are 0.16 of the pull behind a good lens to 0.33 behind a poor
  // one.
  constexpr double left = 0.25;
  const double taken = maps.contrast.empty() ? 0 : std::abs(maps.contrast(column, row));
  if (taken > 0) return left * taken;

  // Variance of the places that a pixel mixes: its area, and half a pixel of blur by a good lens.
  constexpr double seen = 1.0 / 12 + 0.22;  // pixels^2

  double pull = 0;
  for (const auto& [right, down] : {std::pair{1, 0}, std::pair{0, 1}}) {
    double modulation = 0, coordinate = 0;
    int count = 0;
    for (const int side : {-1, 1}) {
      const int x = column + side * right, y = row + side * down;
      if (x < 0 || y < 0 || x >= cloud.size().width || y >= cloud.size().height) continue;

      const Validity validity = cloud.validity(x, y);
      if (validity != Validity::valid && validity != Validity::saturated) continue;
      modulation += side * (double{maps.modulation(x, y)} - maps.modulation(column, row));
      coordinate += side * (double{maps.coordinate(x, y)} - maps.coordinate(column, row));
      ++count;
    }
    if (count > 0) pull += modulation * coordinate / (count * count);
  }

  return seen * std::abs(pull) / maps.modulation(column, row);
}

/// How far the depth changes within two pixels, mm, if a step lies as near: between two pixels side
/// by side, one of them beside this one, or across a pixel without light. Else 0.
double change_within_blur(const Cloud& cloud, const Surroundings& around, int column, int row,
                          double noise) {
  constexpr int side = 5;
  const double least = steep * around.across + deviations * noise;
  const double most = largest * around.across;

  // 1. The depths, NaN without a point, and how far they are from this pixel's. NaN compares false.
  std::array<float, side * side> z{};
  z.fill(std::numeric_limits<float>::quiet_NaN());
  const float here = cloud.z(column, row);
  float change = 0;

  for (int y = std::max(row - 2, 0); y <= std::min(row + 2, cloud.size().height - 1); ++y) {
    for (int x = std::max(column - 2, 0); x <= std::min(column + 2, cloud.size().width - 1); ++x) {
      const float there = cloud.z(x, y), apart = std::abs(there - here);
      z[(y - row + 2) * side + x - column + 2] = there;
      if (apart <= most && apart > change) change = apart;
    }
  }

  // 2. Without a step between two of them, half as far from one at least, it is a slope.
  if (change < least / 2) return 0;
  if (around.at_unlit && change > 1.5 * least) return change;

  const auto is_beside = [](int i) {
    return i % side > 0 && i % side < side - 1 && i / side > 0 && i / side < side - 1;
  };
  const auto has_step = [&](int i, int next) {
    const float apart = std::abs(z[next] - z[i]);
    return apart > least && apart <= most && (is_beside(i) || is_beside(next));
  };
  for (int i = 0; i < side * side; ++i) {
    if (i % side < side - 1 && has_step(i, i + 1)) return change;
    if (i / side < side - 1 && has_step(i, i + side)) return change;
  }
  return 0;
}

}  // namespace

double edge_sigma(const Cloud& cloud, const Maps& maps, int column, int row, double depth_by_y,
                  double noise) {
  const Surroundings around = surroundings(cloud, maps, column, row, depth_by_y, noise);

  // At a step the pixel may see either surface with a part of its area, whose centre is up to half
  // a pixel off the pixel's, evenly distributed. A small step looks like a steep slope, on which a
  // pixel sees both.
  //
  // Up to two pixels from a step, the lens mixes in a tenth of the other surface. Beside a pixel
  // without light, a pixel may see only the near side of a step that its centre lies beyond.
  const double near_step = (around.at_unlit ? off_centre : by_lens) *
                           change_within_blur(cloud, around, column, row, noise * depth_by_y) /
                           depth_by_y;
  if (around.at_step) return std::max(near_step, off_centre * std::ranges::max(around.change));

  const double pull = std::max(near_step, pull_of_contrast(cloud, maps, column, row));
  if (!around.at_unlit) return pull;

  // Beside the dark, a pixel is as much darker than its surface as it sees less of it. The centre
  // of the rest moves by half of that in a sharp pixel, by more behind a lens: on virtual scans
  // 0.5 to 1.1, least where the light ends and most at silhouettes.
  constexpr double off_by_dark = 0.7;
  const double hidden = 1 - maps.modulation(column, row) / around.brightest;
  const double change = change_along(around, around.away.normalized());

  return std::max(pull, off_by_dark * hidden * change);
}

}  // namespace slipstream
