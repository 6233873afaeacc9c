#include "merge/surface_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "base/linear_algebra.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "merge/point_grid.h"

namespace slipstream {
namespace {

/// The matches of samples of `from` on `to`; `back`: `from` is the first view's surface, so
/// that the matches are turned round.
std::vector<SurfaceMatch> matches_on(const SurfaceSamples& from, const SurfaceSamples& to,
                                     const Eigen::Isometry3d& pose, float farthest,
                                     std::size_t step, bool back) {
  const auto sigma_of = [](const SurfaceSamples& surface, std::span<const float> sigma,
                           std::uint32_t i) {
    return sigma.empty() ? surface.level_sigma : sigma[i];
  };
  const std::size_t count = from.sample.empty() ? from.points.size() : from.sample.size();
  const Eigen::Isometry3f motion = pose.cast<float>();

  std::vector<std::optional<SurfaceMatch>> found((count + step - 1) / step);
  for_each_row(static_cast<int>(found.size()), [&](int row) {
    const std::size_t place = static_cast<std::size_t>(row) * step;
    const std::uint32_t i =
        from.sample.empty() ? static_cast<std::uint32_t>(place) : from.sample[place];

    const Eigen::Vector3f point = motion * from.points[i];
    const Eigen::Vector3f normal = motion.linear() * from.normals[i];
    const auto partner = partner_of(point, normal, to, farthest);
    if (!partner) return;

    const Eigen::Vector3d target = to.smooth_points[*partner].cast<double>();
    SurfaceMatch match{.place = point.cast<double>(),
                       .first_normal = to.normals[*partner].cast<double>(),
                       .second_normal = normal.cast<double>(),
                       .sigma = std::hypot(sigma_of(from, from.sigma, i),
                                           sigma_of(to, to.smooth_sigma, *partner))};
    const Eigen::Vector3d apart = target - match.place;
    match.distance = match.direction().dot(apart);

    if (back) {
      // All in the frame of the first view, which is `from` here.
      const Eigen::Isometry3d home = pose.inverse();
      match.place = home * target;
      match.first_normal = from.normals[i].cast<double>();
      match.second_normal = home.linear() * to.normals[*partner].cast<double>();
      match.distance = -match.distance;
    }
    found[static_cast<std::size_t>(row)] = match;
  });

  std::vector<SurfaceMatch> all;
  for (const std::optional<SurfaceMatch>& match : found) {
    if (match) all.push_back(*match);
  }
  return all;
}

/// Derivatives of a match's distance along a normal by a small turn and shift about `centre`.
Vector6 row_of(const SurfaceMatch& match, const Eigen::Vector3d& normal,
               const Eigen::Vector3d& centre) {
  Vector6 row;
  row << (match.place - centre).cross(normal), normal;
  return row;
}

/// Turns in units of a shift at the extent of the surface.
Vector6 units_of(double extent) {
  Vector6 units;
  units << Eigen::Vector3d::Constant(1 / extent), Eigen::Vector3d::Ones();
  return units;
}

}  // namespace

SurfaceSamples coarse_surface(const PreparedView& view) {
  const Keypoints& keypoints = view.keypoints();
  return {.points = keypoints.points,
          .normals = keypoints.normals,
          .smooth_points = keypoints.points,
          .grid = &view.keypoint_grid(),
          .spacing = keypoints.cell,
          .level_sigma = 0.1F * keypoints.cell};
}

SurfaceSamples fine_surface(const PreparedView& view) {
  return {.points = view.view().points,
          .normals = view.view().normals,
          .sigma = view.sigma(),
          .smooth_points = view.smooth_points(),
          .smooth_sigma = view.smooth_sigma(),
          .sample = view.sample(),
          .grid = &view.grid(),
          .spacing = view.view().spacing};
}

std::optional<std::uint32_t> partner_of(const Eigen::Vector3f& place, const Eigen::Vector3f& normal,
                                        const SurfaceSamples& other, float farthest) {
  constexpr float least_alike = 0.7F;  // cosine between the normals
  constexpr float beside = 1.2F;       // spacings

  const auto nearest = other.grid->nearest(place, farthest);
  if (!nearest) return std::nullopt;
  if (!(normal.dot(other.normals[*nearest]) > least_alike)) return std::nullopt;

  // Beyond the other's border the nearest point lies to the side.
  const Eigen::Vector3f apart = other.points[*nearest] - place;
  const Eigen::Vector3f along = (normal + other.normals[*nearest]).normalized();
  const float sideways = (apart - apart.dot(along) * along).norm();
  return sideways <= beside * other.spacing ? nearest : std::nullopt;
}

std::vector<SurfaceMatch> match_surfaces(const SurfaceSamples& first, const SurfaceSamples& second,
                                         const Eigen::Isometry3d& pose, float farthest,
                                         std::size_t step) {
  std::vector<SurfaceMatch> all = matches_on(second, first, pose, farthest, step, false);
  const auto back = matches_on(first, second, pose.inverse(), farthest, step, true);
  all.insert(all.end(), back.begin(), back.end());
  return all;
}

Eigen::Vector3d centre_of(const std::vector<SurfaceMatch>& matches) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SurfaceMatch& match : matches) sum += match.place;
  return sum / std::max(static_cast<double>(matches.size()), 1.0);
}

SurfaceEquations equations_of(const std::vector<SurfaceMatch>& matches,
                              const Eigen::Vector3d& centre) {
  SurfaceEquations equations;
  if (matches.empty()) return equations;

  // The spread of the distances decides which are outliers, not a fixed distance.
  const double size = median_of(
      matches, [](const SurfaceMatch& match) { return std::abs(match.distance) / match.sigma; });
  equations.scale = std::max(deviation_from_median(size), 1.0);

  for (const SurfaceMatch& match : matches) {
    const double spread = match.sigma * equations.scale;
    const double weight = tukey_weight(match.distance / spread) / (spread * spread);
    if (weight == 0) continue;

    const Vector6 row = row_of(match, match.direction(), centre);
    equations.squares.noalias() += weight * row * row.transpose();
    equations.right += weight * match.distance * row;

    const Vector6 one = row_of(match, match.first_normal, centre);
    const Vector6 other = row_of(match, match.second_normal, centre);
    equations.information.noalias() +=
        weight / 2 * (one * other.transpose() + other * one.transpose());
    equations.weight += weight;
  }

  return equations;
}

void PatchScatter::add(std::size_t first, std::size_t second, const Eigen::Isometry3d& pose,
                       const std::vector<SurfaceMatch>& matches, const Eigen::Vector3d& centre,
                       const Eigen::Matrix<double, 6, Eigen::Dynamic>& derivatives) {
  const auto parameters = derivatives.cols();
  if (squares_.size() == 0) {
    squares_ = counted_twice_ = Eigen::MatrixXd::Zero(parameters, parameters);
  }
  const SurfaceEquations equations = equations_of(matches, centre);
  squares_ += derivatives.transpose() * equations.squares * derivatives;
  weights_ += equations.weight;

  // 1. Sums over the matches between two patches.
  const Eigen::Isometry3d to_second = pose.inverse();
  const auto cell_of = [&](const Eigen::Vector3d& place) {
    return cell_key((place / patch_).array().floor().cast<int>());
  };
  // A robust fit follows a residual by the slope of its influence, not by its weight.
  constexpr double small = 1e-3;
  const auto influence = [](double residual) { return residual * tukey_weight(residual); };
  std::map<std::pair<std::uint64_t, std::uint64_t>, Vector6> between;

  for (const SurfaceMatch& match : matches) {
    const double spread = match.sigma * equations.scale, residual = match.distance / spread;
    slopes_ +=
        (influence(residual + small) - influence(residual - small)) / (2 * small * spread * spread);

    const Vector6 row = row_of(match, match.direction(), centre);
    const std::pair cells(cell_of(match.place), cell_of(to_second * match.place));
    between.try_emplace(cells, Vector6::Zero()).first->second += influence(residual) / spread * row;
  }

  // 2. Sums over each patch. Two matches of the same two patches are in both of these sums.
  for (const auto& [cells, sum] : between) {
    const Eigen::VectorXd of_parameters = derivatives.transpose() * sum;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(parameters);
    for (const Patch& patch : {Patch(first, cells.first), Patch(second, cells.second)}) {
      sums_.try_emplace(patch, zero).first->second += of_parameters;
    }
    counted_twice_ += of_parameters * of_parameters.transpose();
  }
}

double PatchScatter::matches_each() const {
  if (sums_.empty()) return 1;
  Eigen::MatrixXd scatter = -counted_twice_;
  for (const auto& [patch, sum] : sums_) scatter += sum * sum.transpose();

  // The mean over the parameters that the matches determine, of any units.
  const auto [determined, rank] = least_squares(squares_, scatter);
  const double excess = determined.trace() / static_cast<double>(rank);
  const double followed = slopes_ / weights_;
  return std::max(1.0, excess / (followed * followed));
}

double extent_of(const std::vector<SurfaceMatch>& matches, const Eigen::Vector3d& centre) {
  double squares = 0;
  for (const SurfaceMatch& match : matches) squares += (match.place - centre).squaredNorm();
  return std::sqrt(squares / std::max(static_cast<double>(matches.size()), 1.0));
}

WeakestMotion weakest_motion(const SurfaceEquations& equations, double extent) {
  constexpr double none = 1e-12;

  const Vector6 units = units_of(extent);
  const PrincipalAxes axes =
      principal_axes(units.asDiagonal() * equations.information * units.asDiagonal());
  const double least = std::max(axes.values(0), none);
  return {.slope = std::sqrt(least / std::max(equations.weight, none)),
          .sigma = 1 / std::sqrt(least),
          .motion = units.asDiagonal() * axes.vectors.col(0)};
}

Eigen::Isometry3d settled_pose(const SurfaceSamples& first, const SurfaceSamples& second,
                               Eigen::Isometry3d pose, float farthest, float nearest, int rounds,
                               std::size_t step) {
  constexpr std::size_t fewest = 30;
  constexpr double settled = 0.2;  // standard deviations of the pose by the matches' noise

  for (int round = 0; round < rounds; ++round) {
    const auto matches = match_surfaces(first, second, pose, farthest, step);
    if (matches.size() < fewest) return pose;

    const Eigen::Vector3d centre = centre_of(matches);
    const SurfaceEquations equations = equations_of(matches, centre);

    const Vector6 units = units_of(extent_of(matches, centre));
    const Vector6 right = units.asDiagonal() * equations.right;
    const Vector6 move =
        known_step(units.asDiagonal() * equations.squares * units.asDiagonal(), right);

    pose = motion_about(centre, units.asDiagonal() * move) * pose;
    pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().matrix();

    // Narrow the search; stop at the narrowest once a move is small beside the noise. Below it,
    // points that change their partners may move the pose to and fro for ever.
    if (farthest == nearest && move.dot(right) < settled * settled) break;
    farthest = std::max(nearest, 0.7F * farthest);
  }

  return pose;
}

}  // namespace slipstream
