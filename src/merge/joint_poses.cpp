#include "merge/joint_poses.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Sparse>

#include "geometry/rotation.h"
#include "merge/consensus.h"
#include "merge/surface_fit.h"

namespace slipstream {
namespace {

/// Normal equations for small motions, about the origin of the common frame, of all views that have
/// a pose but the first of them.
class PoseEquations {
 public:
  explicit PoseEquations(const Poses& poses) : place_(poses.size(), -1) {
    int count = -1;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (poses[i]) place_[i] = count++;
    }
    right_ = Eigen::VectorXd::Zero(6 * std::max(count, 0));
  }

  /// Adds those of a link for a motion of its second view: moving the first has the opposite
  /// effect.
  void add(const ViewLink& link, const Matrix6& squares, const Vector6& right) {
    const int one = place_[link.first], other = place_[link.second];
    add_block(one, one, squares);
    add_block(other, other, squares);
    add_block(one, other, -squares);
    add_block(other, one, -squares);
    if (one >= 0) right_.segment<6>(6 * one) -= right;
    if (other >= 0) right_.segment<6>(6 * other) += right;
  }

  /// Solves them and moves the poses; returns the largest displacement, mm.
  [[nodiscard]] double move(const std::vector<PreparedView>& views, Poses& poses) const {
    if (right_.size() == 0) return 0;

    // A little more on the diagonal holds what no link determines.
    Eigen::SparseMatrix<double> matrix(right_.size(), right_.size());
    matrix.setFromTriplets(squares_.begin(), squares_.end());
    for (Eigen::Index i = 0; i < right_.size(); ++i) matrix.coeffRef(i, i) *= 1 + 1e-9;

    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    const Eigen::VectorXd step = solver.solve(right_);
    if (solver.info() != Eigen::Success || !step.allFinite()) return 0;

    // Move, and keep the rotations exact.
    double most = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (place_[i] < 0) continue;
      const Eigen::Isometry3d before = *poses[i];
      Eigen::Isometry3d& pose = *poses[i];
      pose = motion_about(Eigen::Vector3d::Zero(), step.segment<6>(6 * place_[i])) * pose;
      pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().matrix();
      most =
          std::max(most, largest_displacement(before, pose, views[i].middle(), views[i].reach()));
    }

    return most;
  }

 private:
  void add_block(int row, int column, const Matrix6& block) {
    if (row < 0 || column < 0) return;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) {
        squares_.emplace_back(6 * row + r, 6 * column + c, block(r, c));
      }
    }
  }

  std::vector<int> place_;
  std::vector<Eigen::Triplet<double>> squares_{};
  Eigen::VectorXd right_;
};

}  // namespace

double contradiction(const PreparedView& second, const Eigen::Isometry3d& pose,
                     const Eigen::Isometry3d& other) {
  return largest_displacement(pose, other, second.middle(), second.reach());
}

void balance_links(const std::vector<PreparedView>& views, const std::vector<ViewLink>& links,
                   Poses& poses) {
  constexpr int rounds = 20;
  constexpr double settled = 1e-3;  // spacings

  const double usual = views.front().view().spacing;
  for (int round = 0; round < rounds; ++round) {
    PoseEquations equations(poses);
    for (const ViewLink& link : links) {
      if (!poses[link.first] || !poses[link.second]) continue;

      // The motion that the link asks of its second view.
      const PreparedView& second = views[link.second];
      const Eigen::Isometry3d& pose = *poses[link.second];
      const Eigen::Isometry3d wanted = *poses[link.first] * link.alignment.pose;
      const Eigen::Isometry3d motion = wanted * pose.inverse();
      const Eigen::AngleAxisd turn(motion.linear());
      const Eigen::Vector3d middle = pose * second.middle();

      Vector6 step;
      step << turn.angle() * turn.axis(),
          motion * middle - middle - turn.angle() * turn.axis().cross(middle);

      // Weighted by how far it moves the view's points.
      Eigen::Matrix<double, 3, 6> moved;
      moved << -cross_matrix(middle), Eigen::Matrix3d::Identity();
      Matrix6 squares = moved.transpose() * moved;
      squares.diagonal().head<3>().array() += 2.0 / 3 * second.reach() * second.reach();
      const double off = contradiction(second, wanted, pose);
      squares *= 1 / (1 + std::pow(off / usual, 2));
      equations.add(link, squares, squares * step);
    }

    if (equations.move(views, poses) < settled * usual) break;
  }
}

void refine_jointly(const std::vector<PreparedView>& views, const std::vector<ViewLink>& links,
                    int rounds, Poses& poses) {
  constexpr std::size_t most_matches = 2'000'000;  // of all links together
  constexpr double settled = 1e-4;                 // spacings

  const std::size_t each = most_matches / std::max<std::size_t>(links.size(), 1);
  for (int round = 0; round < rounds; ++round) {
    PoseEquations equations(poses);
    for (const ViewLink& link : links) {
      if (!poses[link.first] || !poses[link.second]) continue;

      // The distances between both surfaces, in the common frame.
      const PreparedView &first = views[link.first], &second = views[link.second];
      const Eigen::Isometry3d& to_common = *poses[link.first];
      const std::size_t step = (first.sample().size() + second.sample().size()) / each + 1;
      auto matches = match_surfaces(
          fine_surface(first), fine_surface(second), to_common.inverse() * *poses[link.second],
          3 * std::max(first.view().spacing, second.view().spacing), step);

      for (SurfaceMatch& match : matches) {
        match.place = to_common * match.place;
        match.first_normal = to_common.linear() * match.first_normal;
        match.second_normal = to_common.linear() * match.second_normal;
      }

      const SurfaceEquations of_link = equations_of(matches, Eigen::Vector3d::Zero());
      equations.add(link, of_link.squares, of_link.right);
    }

    if (equations.move(views, poses) < settled * views.front().view().spacing) break;
  }
}

}  // namespace slipstream
