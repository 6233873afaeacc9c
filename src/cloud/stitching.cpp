#include "cloud/stitching.h"

#include <cmath>
#include <vector>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "cloud/object_model.h"
#include "slipstream/surface.h"

namespace slipstream {
namespace {

/// The points of a cloud with normals, in its camera's frame.
std::vector<ModelElement> elements_of(const Cloud& cloud, const Normals& normals) {
  std::vector<ModelElement> elements;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const Eigen::Vector3f position(cloud.x.begin()[i], cloud.y.begin()[i], cloud.z.begin()[i]);
    const Eigen::Vector3f normal(normals.x.begin()[i], normals.y.begin()[i], normals.z.begin()[i]);
    if (!position.allFinite() || !normal.allFinite()) continue;
    elements.push_back(
        {.position = position, .normal = normal, .intensity = 0, .weight = 1, .views = 1});
  }
  return elements;
}

/// Distances of the points from the planes of the first view's points in their pixels, and the
/// middle of the points.
struct Overlap {
  std::vector<double> distances;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
};

Overlap overlap_of(const std::vector<ModelElement>& elements, const Cloud& first,
                   const Normals& normals, const Lens& camera, const Eigen::Isometry3d& pose) {
  constexpr double farthest = 20;      // pixel widths
  constexpr double least_alike = 0.7;  // cosine between the normals

  Overlap overlap;
  for (const ModelElement& element : elements) {
    const Eigen::Vector3d point = pose * element.position.cast<double>();
    if (!(point.z() > 0)) continue;

    const Eigen::Vector2d pixel = project(camera, point).array().round();
    const auto [width, height] = first.size();
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < width && pixel.y() < height)) continue;
    const int column = static_cast<int>(pixel.x()), row = static_cast<int>(pixel.y());

    const Eigen::Vector3d normal(normals.x(column, row), normals.y(column, row),
                                 normals.z(column, row));
    const Eigen::Vector3d there(first.x(column, row), first.y(column, row), first.z(column, row));
    const Eigen::Vector3d own = pose.linear() * element.normal.cast<double>();
    const double distance = normal.dot(point - there);
    if (!(normal.dot(own) > least_alike)) continue;
    if (!(std::abs(distance) < farthest * point.z() / camera.intrinsic(0, 0))) continue;

    overlap.distances.push_back(std::abs(distance));
    overlap.middle += point;
  }
  if (!overlap.distances.empty()) overlap.middle /= static_cast<double>(overlap.distances.size());
  return overlap;
}

}  // namespace

Stitching stitched(const Cloud& first, const Cloud& second, const Lens& camera,
                   const Eigen::Isometry3d& second_to_first) {
  for (const Cloud* cloud : {&first, &second}) {
    throw_if(cloud->size() != camera.size,
             "a cloud has {} pixels and the camera {}; give organised clouds of this camera",
             text_of(cloud->size()), text_of(camera.size));
  }
  const Normals normals = surface_normals(first);
  const std::vector<ModelElement> elements = elements_of(second, surface_normals(second));

  // 1. The views as the robot places them.
  constexpr std::size_t fewest = 500;
  Overlap overlap = overlap_of(elements, first, normals, camera, second_to_first);
  throw_if(overlap.distances.size() < fewest,
           "the views share only {} points; scan the same surface from both poses, or the hand-eye "
           "pose is far off",
           overlap.distances.size());
  Stitching result{.points = overlap.distances.size(),
                   .median = quantile(overlap.distances, 0.5),
                   .percentile_95 = quantile(overlap.distances, 0.95)};

  // 2. As they meet best.
  const Registration found = register_to(elements, first, normals, camera, second_to_first);
  const Eigen::Isometry3d correction = found.pose * second_to_first.inverse();
  result.offset = overlap.middle - correction * overlap.middle;
  result.rotation = Eigen::AngleAxisd(correction.linear()).angle();

  Overlap after = overlap_of(elements, first, normals, camera, found.pose);
  if (!after.distances.empty()) result.left_median = quantile(after.distances, 0.5);
  return result;
}

}  // namespace slipstream
