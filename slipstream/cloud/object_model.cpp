#include "slipstream/cloud/object_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "slipstream/base/error.h"
#include "slipstream/cloud/seen_element.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

constexpr std::size_t fewest_to_begin = 1000;
constexpr double near_pixels = 3;  // widths of a pixel, within which two points are one surface's

/// The point of the element's normal that lies in the plane through the cloud's point: from the
/// element, mm. Its own place along the surface stays, so that elements keep their distances.
double along_normal(const SeenElement& seen) {
  return seen.cloud_normal.dot(seen.cloud_point - seen.point) / seen.cloud_normal.dot(seen.normal);
}

void take_mean(ModelElement& element, const SeenElement& seen, const Eigen::Isometry3d& pose,
               float intensity) {
  const auto weight = static_cast<float>(std::pow(facing(seen.cloud_point, seen.cloud_normal), 2));
  element.weight += weight;
  const float share = weight / element.weight;
  element.position += share * static_cast<float>(along_normal(seen)) * element.normal;
  const Vector normal = pose.linear().transpose() * seen.cloud_normal;
  element.normal = (element.normal + share * (normal.cast<float>() - element.normal)).normalized();
  element.intensity += share * (intensity - element.intensity);
  ++element.views;
}

/// The four pixels about a place.
void cover(Image<std::uint8_t>& covered, const Eigen::Vector2d& pixel) {
  const int left = static_cast<int>(std::floor(pixel.x()));
  const int top = static_cast<int>(std::floor(pixel.y()));
  for (int row = std::max(top, 0); row <= std::min(top + 1, covered.height() - 1); ++row) {
    for (int column = std::max(left, 0); column <= std::min(left + 1, covered.width() - 1);
         ++column) {
      covered(column, row) = 1;
    }
  }
}

}  // namespace

bool ObjectModel::fits(const Registration& registration, const Cloud& cloud) const {
  constexpr std::size_t fewest = 200;
  constexpr double least_share = 0.75, most_rms = 0.7;  // pixels' widths
  const double depth = (registration.pose * elements_.front().position.cast<double>()).z();
  return cloud.size() == camera_.size && registration.points >= fewest &&
         registration.share > least_share &&
         registration.rms < most_rms * depth / camera_.intrinsic(0, 0);
}

Eigen::Isometry3d ObjectModel::expected_at(double time) const {
  if (!(last_.time > before_last_.time)) return last_.pose;
  const double share = (time - last_.time) / (last_.time - before_last_.time);
  const Eigen::AngleAxisd turn(last_.pose.linear() * before_last_.pose.linear().transpose());
  const Vector place = last_.pose * middle_, step = place - before_last_.pose * middle_;
  Eigen::Isometry3d onward = Eigen::Isometry3d::Identity();
  onward.translate(place + share * step);
  onward.rotate(Eigen::AngleAxisd(share * turn.angle(), turn.axis()));
  onward.translate(-place);
  return onward * last_.pose;
}

bool ObjectModel::add(const Cloud& cloud, double time) {
  if (cloud.size() != camera_.size) throw Error("a view is not of the size of the camera's others");
  const Normals normals = smoothed_normals(cloud);
  if (!elements_.empty()) {
    Registration found = register_to(elements_, cloud, normals, camera_, expected_at(time));
    if (!fits(found, cloud)) found = register_to(elements_, cloud, normals, camera_, last_.pose);
    if (!fits(found, cloud)) {
      ++left_out_;
      return false;
    }
    registration_ = found;
  }
  add_uncovered(cloud, normals, take_mean(cloud, normals));
  if (elements_.size() < fewest_to_begin) {
    elements_.clear();
    ++left_out_;
    return false;
  }
  if (views_ == 0) {
    for (const ModelElement& element : elements_) {
      middle_ += element.position.cast<double>() / static_cast<double>(elements_.size());
    }
  }
  before_last_ = views_ == 0 ? Seen{time, registration_.pose} : last_;
  last_ = {time, registration_.pose};
  ++views_;
  return true;
}

Image<std::uint8_t> ObjectModel::take_mean(const Cloud& cloud, const Normals& normals) {
  constexpr double least_alike = 0.6;  // cosine between the normals
  Image<std::uint8_t> covered(cloud.size(), 0);
  bool seen_through = false;
  for (ModelElement& element : elements_) {
    const auto seen = seen_element(element, registration_.pose, cloud, normals, camera_);
    if (!seen || !(seen->cloud_point.z() > 0)) continue;
    const double near = near_pixels * pixel_width(camera_, seen->point);
    const double behind = seen->cloud_point.z() - seen->point.z();
    if (behind < -near) continue;  // hidden by another part
    if (behind > 2 * near) {
      seen_through |= --element.views < 0;
      continue;
    }
    cover(covered, seen->pixel);
    if (!(seen->normal.dot(seen->cloud_normal) > least_alike)) continue;
    if (std::abs(along_normal(*seen)) > near) continue;
    slipstream::take_mean(element, *seen, registration_.pose,
                          cloud.intensity(seen->column, seen->row));
  }
  if (seen_through) {
    std::erase_if(elements_, [](const ModelElement& element) { return element.views < 0; });
  }
  return covered;
}

void ObjectModel::add_uncovered(const Cloud& cloud, const Normals& normals,
                                const Image<std::uint8_t>& covered) {
  constexpr double least_facing = 0.4;
  const Eigen::Isometry3d to_object = registration_.pose.inverse();
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      if (covered(column, row) != 0) continue;
      const Vector point = position_at(cloud, column, row);
      const Vector normal = normal_at(normals, column, row);
      const double faces = facing(point, normal);
      if (!(faces > least_facing)) continue;
      elements_.push_back({(to_object * point).cast<float>(),
                           (to_object.linear() * normal).cast<float>(),
                           cloud.intensity(column, row), static_cast<float>(faces * faces), 1});
    }
  }
}

ModelPoints ObjectModel::points() const {
  std::vector<ModelElement> sure;
  std::copy_if(elements_.begin(), elements_.end(), std::back_inserter(sure),
               [&](const ModelElement& element) { return element.views >= std::min(views_, 3); });
  const Size size{static_cast<int>(sure.size()), 1};
  ModelPoints points{Cloud(size), {Image<float>(size), Image<float>(size), Image<float>(size)}};
  for (int i = 0; i < size.width; ++i) {
    const ModelElement& element = sure[static_cast<std::size_t>(i)];
    points.cloud.x(i, 0) = element.position.x();
    points.cloud.y(i, 0) = element.position.y();
    points.cloud.z(i, 0) = element.position.z();
    points.cloud.intensity(i, 0) = element.intensity;
    points.cloud.validity(i, 0) = Validity::valid;
    points.normals.x(i, 0) = element.normal.x();
    points.normals.y(i, 0) = element.normal.y();
    points.normals.z(i, 0) = element.normal.z();
  }
  return points;
}

}  // namespace slipstream
