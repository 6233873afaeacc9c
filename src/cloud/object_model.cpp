#include "cloud/object_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/point_fit.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

Vector normal_at(const Normals& normals, int column, int row) {
  return {normals.x(column, row), normals.y(column, row), normals.z(column, row)};
}

/// Cosine between a surface's normal and the viewing direction: 1 if it faces the camera.
double facing(const Vector& point, const Vector& normal) {
  return -normal.dot(point.normalized());
}

/// An element in the camera's frame, and the point of the cloud in its pixel.
struct SeenElement {
  Vector point, normal;              ///< of the element
  Eigen::Vector2d pixel;             ///< its projection
  int column = 0, row = 0;           ///< the nearest pixel
  Vector cloud_point, cloud_normal;  ///< NaN without a point
};

/// nullopt if the element faces away, is slanted too much or lies outside the picture.
std::optional<SeenElement> seen_element(const ModelElement& element, const Eigen::Isometry3d& pose,
                                        const Cloud& cloud, const Normals& normals,
                                        const Lens& camera) {
  constexpr double least_facing = 0.3;

  SeenElement seen;
  seen.normal = pose.linear() * element.normal.cast<double>();
  seen.point = pose * element.position.cast<double>();

  if (!(seen.point.z() > 0) || facing(seen.point, seen.normal) < least_facing) return std::nullopt;

  // The pixel that sees it, and the point of the cloud there.
  seen.pixel = project(camera, seen.point);
  const Eigen::Vector2d nearest = seen.pixel.array().round();
  const auto [width, height] = cloud.size();
  if (!(nearest.x() >= 0 && nearest.y() >= 0 && nearest.x() < width && nearest.y() < height)) {
    return std::nullopt;
  }

  seen.column = static_cast<int>(nearest.x());
  seen.row = static_cast<int>(nearest.y());
  seen.cloud_point = position_at(cloud, seen.column, seen.row);
  seen.cloud_normal = normal_at(normals, seen.column, seen.row);

  return seen;
}

/// Distance between the rays of neighbouring pixels at a point, mm.
double pixel_width(const Lens& camera, const Vector& point) {
  return point.z() / camera.intrinsic(0, 0);
}

/// An element's position, and the distance of the cloud from it along the sum of both normals.
struct Match {
  Vector point, direction;
  double distance = 0;
};

struct Matches {
  std::vector<Match> matches;
  std::size_t expected = 0;  // visible elements whose pixel has a point of the cloud
  double squares = 0;        // of the distances
};

Matches match(std::span<const ModelElement> object, const Cloud& cloud, const Normals& normals,
              const Lens& camera, const Eigen::Isometry3d& pose, double farthest_pixels) {
  constexpr std::size_t most_elements = 20'000;  // half of them face away
  constexpr double least_alike = 0.8;            // cosine between the normals

  Matches found;
  const std::size_t step = object.size() / most_elements + 1;
  for (std::size_t i = 0; i < object.size(); i += step) {
    const auto seen = seen_element(object[i], pose, cloud, normals, camera);
    if (!seen || !(seen->cloud_point.z() > 0)) continue;

    const Vector apart = seen->cloud_point - seen->point;
    const double farthest = farthest_pixels * pixel_width(camera, seen->point);
    // An element far behind the cloud is hidden by another part of the object.
    if (apart.z() > -2 * farthest) ++found.expected;

    // Near enough, and with a similar slope.
    if (!(apart.squaredNorm() <= farthest * farthest)) continue;
    if (!(seen->normal.dot(seen->cloud_normal) > least_alike)) continue;

    const Vector direction = (seen->normal + seen->cloud_normal).normalized();
    found.matches.push_back({seen->point, direction, direction.dot(apart)});
    found.squares += std::pow(found.matches.back().distance, 2);
  }

  return found;
}

/// The motion that brings the elements nearest to the cloud; zero in poorly determined directions.
Eigen::Isometry3d nearer(const Matches& found) {
  // 1. Centre and extent of the elements, so that turns and shifts have similar size.
  const auto count = static_cast<double>(found.matches.size());
  const double rms = std::sqrt(found.squares / count);

  Vector centre = Vector::Zero();
  for (const Match& match : found.matches) centre += match.point / count;
  double extent = 0;
  for (const Match& match : found.matches) extent += (match.point - centre).squaredNorm() / count;
  extent = std::sqrt(extent);

  // 2. Normal equations of the distances, linear in the turn and the shift. Distances beyond about
  // twice the rms lose weight.
  Matrix6 squares = Matrix6::Zero();
  Vector6 right = Vector6::Zero();

  for (const Match& match : found.matches) {
    Vector6 row;
    row << ((match.point - centre) / extent).cross(match.direction), match.direction;

    const double weight = 1 / (1 + std::pow(match.distance / (2 * rms), 2));
    squares.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    right += weight * match.distance * row;
  }

  // 3. The motion turns about the centre.
  Vector6 step = known_step(squares, right);
  step.head<3>() /= extent;
  return motion_about(centre, step);
}

constexpr std::size_t fewest_to_begin = 1000;
constexpr double near_pixels = 3;  // pixel widths; closer points belong to one surface

}  // namespace

Registration register_to(std::span<const ModelElement> object, const Cloud& cloud,
                         const Normals& normals, const Lens& camera,
                         const Eigen::Isometry3d& guess) {
  constexpr int most_rounds = 20;
  constexpr double first_pixels = 12, last_pixels = 3;  // largest distance of a match, pixel widths
  constexpr std::size_t fewest = 50;
  constexpr double settled = 1e-3;  // pixel widths

  Registration result{.pose = guess};
  double farthest = first_pixels;

  for (int round = 0; round < most_rounds; ++round) {
    // Match, and describe the result so far.
    const Matches found = match(object, cloud, normals, camera, result.pose, farthest);
    const auto count = static_cast<double>(found.matches.size());
    result.points = found.matches.size();
    result.share = found.expected > 0 ? count / static_cast<double>(found.expected) : 0;
    result.rms = count > 0 ? std::sqrt(found.squares / count) : 0;

    if (result.points < fewest || result.rms == 0) break;

    // Move the object.
    const Eigen::Isometry3d step = nearer(found);
    result.pose = step * result.pose;
    // Orthonormalise, since rounding accumulates.
    result.pose.linear() = Eigen::Quaterniond(result.pose.linear()).normalized().matrix();

    // Narrow the search from round to round; stop when the pose settles at the narrowest.
    const Vector& place = found.matches.front().point;
    const bool still = (step * place - place).norm() < settled * pixel_width(camera, place);
    if (still && farthest == last_pixels) break;
    farthest = std::max(last_pixels, 0.7 * farthest);
  }

  return result;
}

bool ObjectModel::fits(const Registration& registration, const Cloud& cloud) const {
  constexpr std::size_t fewest = 200;
  constexpr double least_share = 0.75, most_rms = 0.7;  // rms in pixel widths

  const double depth = (registration.pose * elements_.front().position.cast<double>()).z();
  return cloud.size() == camera_.size && registration.points >= fewest &&
         registration.share > least_share &&
         registration.rms < most_rms * depth / camera_.intrinsic(0, 0);
}

Eigen::Isometry3d ObjectModel::expected_at(double time) const {
  if (!(last_.time > before_last_.time)) return last_.pose;

  const double share = (time - last_.time) / (last_.time - before_last_.time);
  const Eigen::AngleAxisd turn(last_.pose.linear() * before_last_.pose.linear().transpose());

  // The middle of the object moves on straight, and the object turns about it.
  const Vector place = last_.pose * middle_, step = place - before_last_.pose * middle_;
  const Eigen::Isometry3d onward = Eigen::Translation3d(place + share * step) *
                                   Eigen::AngleAxisd(share * turn.angle(), turn.axis()) *
                                   Eigen::Translation3d(-place);

  return onward * last_.pose;
}

bool ObjectModel::add(const Cloud& cloud, double time) {
  if (cloud.size() != camera_.size) throw Error("a view's size differs from the camera's");

  const Normals normals = smoothed_normals(cloud);

  // 1. Register the view, from uniform motion or from the last pose.
  if (!elements_.empty()) {
    Registration found = register_to(elements_, cloud, normals, camera_, expected_at(time));
    if (!fits(found, cloud)) found = register_to(elements_, cloud, normals, camera_, last_.pose);
    if (!fits(found, cloud)) {
      ++left_out_;
      return false;
    }
    registration_ = found;
  }

  // 2. Average the view in, and add pixels that no element covers.
  add_uncovered(cloud, normals, take_mean(cloud, normals));
  if (views_ == 0 && elements_.size() < fewest_to_begin) {
    elements_.clear();
    ++left_out_;
    return false;
  }

  // 3. Remember the pose.
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

    // 1. Compare depths: the element may be hidden, or the view sees through it.
    const double near = near_pixels * pixel_width(camera_, seen->point);
    const double behind = seen->cloud_point.z() - seen->point.z();
    if (behind < -near) continue;  // hidden by another part

    if (behind > 2 * near) {
      seen_through |= --element.views < 0;
      continue;
    }

    // 2. It covers its pixels, even if the view does not change it.
    const Eigen::Vector2i corner = seen->pixel.array().floor().cast<int>();
    for_each_pixel_in_order({2, 2}, [&](int right, int down) {  // the four pixels around it
      const int column = corner.x() + right, row = corner.y() + down;
      const bool inside = column >= 0 && row >= 0;
      if (inside && column < covered.width() && row < covered.height()) covered(column, row) = 1;
    });

    if (!(seen->normal.dot(seen->cloud_normal) > least_alike)) continue;
    // To the plane through the cloud's point. Moving only along the normal preserves the spacing of
    // elements.
    const double along = seen->cloud_normal.dot(seen->cloud_point - seen->point) /
                         seen->cloud_normal.dot(seen->normal);
    if (std::abs(along) > near) continue;

    // 3. Average position, normal and intensity, weighted by the slant of each view.
    const auto weight =
        static_cast<float>(std::pow(facing(seen->cloud_point, seen->cloud_normal), 2));
    element.weight += weight;

    const float share = weight / element.weight;
    element.position += share * static_cast<float>(along) * element.normal;
    const Vector normal = registration_.pose.linear().transpose() * seen->cloud_normal;
    element.normal =
        (element.normal + share * (normal.cast<float>() - element.normal)).normalized();
    element.intensity += share * (cloud.intensity(seen->column, seen->row) - element.intensity);
    ++element.views;
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
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (covered(column, row) != 0) return;

    const Vector point = position_at(cloud, column, row);
    const Vector normal = normal_at(normals, column, row);
    const double faces = facing(point, normal);
    if (!(faces > least_facing)) return;

    elements_.push_back({(to_object * point).cast<float>(),
                         (to_object.linear() * normal).cast<float>(), cloud.intensity(column, row),
                         static_cast<float>(faces * faces), 1});
  });
}

ModelPoints ObjectModel::points() const {
  std::vector<ModelElement> sure = elements_;
  std::erase_if(sure, [&](const ModelElement& e) { return e.views < std::min(views_, 3); });

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
