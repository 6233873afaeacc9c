#pragma once

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

#include "calibrate/pixel_derivatives.h"
#include "slipstream/calibration_board.h"
#include "slipstream/scanner.h"

// Least squares of a calibration by Ceres.
namespace slipstream {

using LensNumbers = std::array<double, lens_number_count>;  ///< fx fy cx cy, distortion
using PoseNumbers = std::array<double, 6>;                  ///< axis times angle, translation

LensNumbers numbers_of(const Lens& lens);
PoseNumbers numbers_of(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);
Eigen::Isometry3d pose_of(const PoseNumbers& numbers);
void set_lens(Lens& lens, const LensNumbers& numbers);

/// Residuals and the parameters that they adjust. The parameters belong to the caller.
class Adjustment {
 public:
  /// `is_robust`: far residuals lose weight, by Huber's loss.
  template <class... Blocks>
  void add(std::unique_ptr<ceres::CostFunction> error, bool is_robust, Blocks*... blocks) {
    // Owned here: the problem would leak them when memory runs out.
    ceres::CostFunction* const owned = errors_.emplace_back(std::move(error)).get();
    problem_.AddResidualBlock(owned, is_robust ? &huber_ : nullptr, blocks...);
  }

  /// Holds a block, if a residual uses it.
  void hold(double* block);

  /// Holds a lens, or all its coefficients after the first ones.
  void settle_lens(LensNumbers& lens, bool held, int coefficients);

  /// Holds the places, or ties them to the printed ones with that deviation, mm.
  void settle_places(BoardPlaces& places, const BoardPlaces& printed,
                     const std::optional<double>& deviation);

  /// Throws Error if it does not converge.
  void solve(double tolerance);

  /// Standard deviations of these blocks one after the other, for independent residuals of
  /// deviation 1; 0 if held. nullopt if the data do not determine the parameters.
  std::optional<Eigen::VectorXd> deviations_of(const std::vector<std::pair<double*, int>>& blocks);

 private:
  static constexpr double huber_reach = 3;  // standard deviations

  std::vector<std::unique_ptr<ceres::CostFunction>> errors_;
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;
  ceres::HuberLoss huber_{huber_reach};
  ceres::Problem problem_{
      ceres::Problem::Options{.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP,
                              .loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP,
                              .manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP}};
};

}  // namespace slipstream
