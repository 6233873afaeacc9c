#include "merge/view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "merge/point_grid.h"

namespace slipstream {
namespace {

constexpr std::size_t fewest_points = 100;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// Median distance of a point from its nearest neighbour.
float median_spacing(std::span<const Eigen::Vector3f> points) {
  constexpr std::size_t most_looked_at = 2000;

  Eigen::Vector3f low = points[0], high = points[0];
  for (const Eigen::Vector3f& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }

  // A surface of that extent, evenly covered, has about this spacing; far points may widen it.
  float cell = (high - low).norm() / std::sqrt(static_cast<float>(points.size()));
  throw_if(!(cell > 0), "its points all lie at one place");

  const std::size_t step = points.size() / most_looked_at + 1;
  while (true) {
    const PointGrid grid(points, cell);
    std::vector<float> distances;
    bool crowded = false;

    for (std::size_t i = 0; i < points.size(); i += step) {
      float least = std::numeric_limits<float>::infinity();
      int near = 0;
      grid.for_each_near(points[i], cell, [&](std::uint32_t index, float squared) {
        ++near;
        if (index != i && squared > 0) least = std::min(least, squared);
      });
      crowded |= near > 2000;
      distances.push_back(std::sqrt(least));
    }

    const float middle = quantile(distances, 0.5);
    // Cells much wider than the spacing are slow, and cells below it miss neighbours.
    if (std::isinf(middle)) {
      cell *= 2;
    } else if (crowded && middle < cell / 8) {
      cell = 4 * middle;
    } else {
      return middle;
    }
  }
}

/// The plane through a point's neighbours.
struct LocalPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Constant(nan);
  float roughness = nan;  ///< standard deviation from the plane, mm
};

/// Sums over neighbours of the products of their offsets (x, y, z, 1) from a place, each weighted
/// by its product with `weight`, at least 0.
Eigen::Matrix4f moments_of(const std::vector<Eigen::Vector4f>& offsets,
                           const Eigen::Vector4f& weight) {
  Eigen::Matrix4f moments = Eigen::Matrix4f::Zero();
  for (const Eigen::Vector4f& offset : offsets) {
    const Eigen::Vector4f weighted = std::max(weight.dot(offset), 0.0F) * offset;
    moments.noalias() += weighted * offset.transpose();
  }
  return moments;
}

/// The plane at a place from its neighbours' offsets (x, y, z, 1).
LocalPlane local_plane(const std::vector<Eigen::Vector4f>& offsets) {
  constexpr std::size_t fewest = 6;
  constexpr float across = 0.05F;  // leaves the offsets across the surface alone

  if (offsets.size() < fewest) return {};
  Eigen::Matrix4f moments = moments_of(offsets, Eigen::Vector4f::UnitW());

  // A slanted surface has more points towards the camera, and a rim points on one side: weighted so
  // that their mean is the place, since the normal is the one at their mean.
  Eigen::Matrix3f squares = moments.topLeftCorner<3, 3>();
  squares.diagonal().array() += across * squares.trace();
  Eigen::Vector4f weight = Eigen::Vector4f::UnitW();
  weight.head<3>() = -squares.ldlt().solve(moments.col(3).head<3>());
  moments = moments_of(offsets, weight);

  const float count = moments(3, 3);
  const Eigen::Vector3f sum = moments.col(3).head<3>();
  const Eigen::Matrix3f scatter = moments.topLeftCorner<3, 3>() - sum * sum.transpose() / count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
  axes.computeDirect(scatter);

  // Neighbours along a line do not determine a normal.
  if (!(axes.eigenvalues()(1) > 0.02F * axes.eigenvalues()(2))) return {};
  const float freedom = std::max(count - 3, 1.0F);
  return {axes.eigenvectors().col(0), std::sqrt(std::max(axes.eigenvalues()(0), 0.0F) / freedom)};
}

/// Roughness below which a fifth of the surface lies: its flattest parts have only the noise.
/// `radius`: within which a point's neighbours are.
float noise_of(std::span<const Eigen::Vector3f> points, float radius) {
  constexpr std::size_t most_looked_at = 5000;
  constexpr double flattest = 0.2;

  const PointGrid grid(points, radius);
  std::vector<float> roughness;
  std::vector<Eigen::Vector4f> offsets;
  const std::size_t step = points.size() / most_looked_at + 1;
  for (std::size_t i = 0; i < points.size(); i += step) {
    offsets.clear();
    grid.for_each_near(points[i], radius, [&](std::uint32_t index, float) {
      offsets.push_back((points[index] - points[i]).homogeneous());
    });
    const LocalPlane plane = local_plane(offsets);
    if (std::isfinite(plane.roughness)) roughness.push_back(plane.roughness);
  }
  return roughness.empty() ? 0 : quantile(roughness, flattest);
}

/// Mean direction of the points, seen from the origin.
Eigen::Vector3f axis_of(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3f axis = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& point : points) axis += point.normalized();
  return axis.normalized();
}

/// Indices of the points in the cone that a camera at the origin sees.
std::vector<std::uint32_t> points_in_cone(std::span<const Eigen::Vector3f> points) {
  constexpr float widest = 0.3F;  // cosine of the angle from the axis

  const Eigen::Vector3f axis = axis_of(points);
  std::vector<std::uint32_t> inside;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (points[i].normalized().dot(axis) > widest) inside.push_back(i);
  }
  return inside;
}

/// Whether of the points, in a camera's cone, only a few are behind another.
bool is_seen_from_origin(std::span<const Eigen::Vector3f> points, float spacing) {
  constexpr float most_hidden = 0.1F;

  const Eigen::Vector3f axis = axis_of(points);
  std::vector<float> ranges;
  for (const Eigen::Vector3f& point : points) ranges.push_back(point.norm());

  // Of the points in each narrow bundle of rays, count those far behind the first.
  const float middle = quantile(ranges, 0.5);
  const float bundle = 3 * spacing / middle;
  const Eigen::Vector3f right = axis.unitOrthogonal(), down = axis.cross(right);
  std::unordered_map<std::uint64_t, float> first;
  const auto bundle_of = [&](const Eigen::Vector3f& point) {
    const Eigen::Vector3f ray = point / point.dot(axis);
    const Eigen::Array2f place(ray.dot(right) / bundle, ray.dot(down) / bundle);
    const Eigen::Array2i cell = place.floor().cast<int>();
    return cell_key({cell.x(), cell.y(), 0});
  };

  for (const Eigen::Vector3f& point : points) {
    float& least = first.try_emplace(bundle_of(point), point.norm()).first->second;
    least = std::min(least, point.norm());
  }

  std::size_t hidden = 0;
  for (const Eigen::Vector3f& point : points) {
    if (point.norm() > first.at(bundle_of(point)) + 20 * spacing) ++hidden;
  }
  return static_cast<float>(hidden) < most_hidden * static_cast<float>(points.size());
}

/// The points of these indices; their normals may be missing.
View kept_of(const View& view, const std::vector<std::uint32_t>& kept) {
  View few{.name = view.name, .spacing = view.spacing, .from_origin = view.from_origin};
  few.points.reserve(kept.size());
  few.normals.reserve(view.normals.empty() ? 0 : kept.size());
  few.sigma.reserve(kept.size());
  few.intensity.reserve(kept.size());
  few.colours.reserve(view.colours.empty() ? 0 : kept.size());

  for (const std::uint32_t i : kept) {
    few.points.push_back(view.points[i]);
    if (!view.normals.empty()) few.normals.push_back(view.normals[i]);
    few.sigma.push_back(view.sigma[i]);
    few.intensity.push_back(view.intensity[i]);
    if (!view.colours.empty()) few.colours.push_back(view.colours[i]);
  }
  return few;
}

/// Finds whether a camera at the origin sees the points; removes the few strays that it cannot.
void find_origin(View& view) {
  constexpr double most_strays = 0.01;

  const std::vector<std::uint32_t> inside = points_in_cone(view.points);
  const auto strays = static_cast<double>(view.size() - inside.size());
  if (strays > most_strays * static_cast<double>(view.size())) return;

  View seen = kept_of(view, inside);
  if (!is_seen_from_origin(seen.points, seen.spacing)) return;
  seen.from_origin = true;
  view = std::move(seen);
}

/// The valid points, without normals; sigma along the ray. Some programs write 0 0 0 for a pixel
/// without a point.
View points_of(const Cloud& cloud, const Uncertainty* uncertainty, std::string name,
               const Image<Colour>* colours) {
  View view{.name = std::move(name)};
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3f point = position_at(cloud, column, row).cast<float>();
    if (!point.allFinite() || point.isZero(0)) return;

    view.points.push_back(point);
    view.intensity.push_back(cloud.intensity(column, row));
    if (colours != nullptr) view.colours.push_back((*colours)(column, row));

    // Noise moves a point along its ray.
    float sigma = nan;
    if (uncertainty != nullptr) {
      sigma = uncertainty->z(column, row) * point.norm() / std::abs(point.z());
    }
    view.sigma.push_back(sigma);
  });

  throw_if(view.size() < fewest_points, "it has {} points; a view needs {} or more", view.size(),
           fewest_points);
  return view;
}

/// Sets the normals, each by the neighbours within `radius`, and makes sigma the one along them.
/// Normals point to the origin or, if the view is not seen from there, away from `middle`.
void set_normals(View& view, float radius, float noise, const Eigen::Vector3f& middle) {
  view.normals.resize(view.size());

  const auto set_normal = [&](std::uint32_t i, const LocalPlane& plane) {
    const Eigen::Vector3f& point = view.points[i];
    const Eigen::Vector3f outwards = view.from_origin ? Eigen::Vector3f(-point) : point - middle;
    const bool is_inwards = plane.normal.dot(outwards) < 0;
    view.normals[i] = is_inwards ? Eigen::Vector3f(-plane.normal) : plane.normal;

    float& sigma = view.sigma[i];
    if (std::isfinite(sigma) && sigma > 0) {
      sigma *= std::abs(plane.normal.dot(point.normalized()));
    } else {
      sigma = noise;
    }
    // Rounding of the files, and rays along the surface.
    sigma = std::max({sigma, noise / 10, 1e-4F * view.spacing});
  };

  const PointGrid grid(view.points, radius);
  grid.for_each_cell([&](std::span<const std::uint32_t> inside, const NearPoints& near) {
    thread_local std::vector<Eigen::Vector4f> offsets;
    for (const std::uint32_t i : inside) {
      offsets.clear();
      near.for_each_near(view.points[i], radius, [&](std::size_t, const Eigen::Vector3f& offset) {
        offsets.push_back(offset.homogeneous());
      });
      set_normal(i, local_plane(offsets));
    }
  });
}

}  // namespace

View view_of(const Cloud& cloud, const Uncertainty* uncertainty, std::string name,
             const Image<Colour>* colours) {
  View view = points_of(cloud, uncertainty, std::move(name), colours);
  view.spacing = median_spacing(view.points);
  find_origin(view);

  // 1. The noise, by which the neighbourhood of a normal is chosen: noise of the normal falls with
  // the square of its radius, to 0.03 rad here.
  constexpr float narrowest = 2.5F, widest = 8;  // radii, in spacings
  constexpr float steadiest = 37;
  const float first_radius = narrowest * view.spacing;
  const float noise = noise_of(view.points, first_radius);
  const float radius =
      std::clamp(std::sqrt(steadiest * noise * view.spacing), first_radius, widest * view.spacing);

  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& point : view.points) {
    middle += point / static_cast<float>(view.size());
  }

  // 2. The normals, and the noise along them.
  set_normals(view, radius, noise, middle);

  // 3. Points with a normal.
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < view.size(); ++i) {
    if (view.normals[i].allFinite()) kept.push_back(i);
  }
  throw_if(kept.size() < fewest_points, "only {} of its {} points have neighbours", kept.size(),
           view.size());
  return kept_of(view, kept);
}

}  // namespace slipstream
