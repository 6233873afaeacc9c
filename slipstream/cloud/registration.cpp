#include "slipstream/cloud/registration.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "slipstream/cloud/seen_element.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// An element's place, and how far from it the cloud lies along the direction of both normals.
struct Match {
  Vector point, direction;
  double distance = 0;
};

struct Matches {
  std::vector<Match> matches;
  std::size_t expected = 0;  // elements that the camera sees with a point of the cloud behind
  double squares = 0;        // of the distances
};

Matches match(std::span<const ModelElement> object, const Cloud& cloud, const Normals& normals,
              const Lens& camera, const Eigen::Isometry3d& pose, double farthest_pixels) {
  constexpr std::size_t most_elements = 20'000;  // half of them are turned away
  constexpr double least_alike = 0.8;            // cosine between the normals
  Matches found;
  const std::size_t step = object.size() / most_elements + 1;
  for (std::size_t i = 0; i < object.size(); i += step) {
    const auto seen = seen_element(object[i], pose, cloud, normals, camera);
    if (!seen || !(seen->cloud_point.z() > 0)) continue;
    const Vector apart = seen->cloud_point - seen->point;
    const double farthest = farthest_pixels * pixel_width(camera, seen->point);
    // What lies far behind the cloud is hidden by another part of the object.
    if (apart.z() > -2 * farthest) ++found.expected;
    if (!(apart.squaredNorm() <= farthest * farthest)) continue;
    if (!(seen->normal.dot(seen->cloud_normal) > least_alike)) continue;
    const Vector direction = (seen->normal + seen->cloud_normal).normalized();
    found.matches.push_back({seen->point, direction, direction.dot(apart)});
    found.squares += std::pow(found.matches.back().distance, 2);
  }
  return found;
}

/// The turn about `centre` and the step that bring the elements nearest to the cloud. Of directions
/// that the matches say next to nothing about there is none.
Eigen::Isometry3d nearer(const Matches& found) {
  constexpr double least_known = 1e-4;  // of the best known direction
  const auto count = static_cast<double>(found.matches.size());
  const double rms = std::sqrt(found.squares / count);
  Vector centre = Vector::Zero();
  for (const Match& match : found.matches) centre += match.point / count;
  double extent = 0;
  for (const Match& match : found.matches) extent += (match.point - centre).squaredNorm() / count;
  extent = std::sqrt(extent);
  Matrix6 squares = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  for (const Match& match : found.matches) {
    Vector6 row;
    row << ((match.point - centre) / extent).cross(match.direction), match.direction;
    const double weight = 1 / (1 + std::pow(match.distance / (2 * rms), 2));
    squares.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    right += weight * match.distance * row;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6> axes(squares);
  Vector6 step = Vector6::Zero();
  for (int i = 0; i < 6; ++i) {
    if (!(axes.eigenvalues()(i) > least_known * axes.eigenvalues()(5))) continue;
    const auto axis = axes.eigenvectors().col(i);
    step += axis.dot(right) / axes.eigenvalues()(i) * axis;
  }
  const Vector turn = step.head<3>() / extent;
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.translate(centre + step.tail<3>());
  moved.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  moved.translate(-centre);
  return moved;
}

}  // namespace

Registration register_to(std::span<const ModelElement> object, const Cloud& cloud,
                         const Normals& normals, const Lens& camera,
                         const Eigen::Isometry3d& guess) {
  constexpr int most_rounds = 20;
  constexpr double first_pixels = 12, last_pixels = 3;  // how far off a match may be
  constexpr std::size_t fewest = 50;
  constexpr double settled = 1e-3;  // pixels' widths
  Registration result{.pose = guess};
  double farthest = first_pixels;
  for (int round = 0; round < most_rounds; ++round) {
    const Matches found = match(object, cloud, normals, camera, result.pose, farthest);
    const auto count = static_cast<double>(found.matches.size());
    result.points = found.matches.size();
    result.share = found.expected > 0 ? count / static_cast<double>(found.expected) : 0;
    result.rms = count > 0 ? std::sqrt(found.squares / count) : 0;
    if (result.points < fewest || result.rms == 0) break;
    const Eigen::Isometry3d step = nearer(found);
    result.pose = step * result.pose;
    // Rounding would grow from product to product.
    result.pose.linear() = Eigen::Quaterniond(result.pose.linear()).normalized().matrix();
    const Vector& place = found.matches.front().point;
    const bool still = (step * place - place).norm() < settled * pixel_width(camera, place);
    if (still && farthest == last_pixels) break;
    farthest = std::max(last_pixels, 0.7 * farthest);
  }
  return result;
}

}  // namespace slipstream
