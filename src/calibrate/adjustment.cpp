#include "calibrate/adjustment.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include <Eigen/SparseCore>
#include <ceres/crs_matrix.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>

#include "base/linear_algebra.h"
#include "base/throw_if-inl.h"
#include "calibrate/corner_errors.h"

namespace slipstream {
namespace {

/// Diagonal of the inverse of J^T J; nullopt if singular.
std::optional<Eigen::VectorXd> variances_of(const ceres::CRSMatrix& jacobian) {
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> J(
      jacobian.num_rows, jacobian.num_cols, std::ssize(jacobian.values), jacobian.rows.data(),
      jacobian.cols.data(), jacobian.values.data());

  const Eigen::MatrixXd normal = J.transpose() * J;
  if (!(normal.diagonal().array() > 0).all()) return std::nullopt;

  // Scale away the units: pixels, radians and millimetres.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();

  // A tiny pivot means a combination of parameters that the data leave free.
  constexpr double least_pivot = 1e-13;
  const auto inverse = inverse_of_symmetric(scaled, least_pivot);
  if (!inverse) return std::nullopt;

  return inverse->diagonal().cwiseProduct(scale.cwiseAbs2());
}

}  // namespace

LensNumbers numbers_of(const Lens& lens) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  LensNumbers numbers{K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
  std::copy_n(lens.distortion.coefficients.begin(), untilted_coefficient_count,
              numbers.begin() + 4);
  return numbers;
}

PoseNumbers numbers_of(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  PoseNumbers numbers{};
  ceres::RotationMatrixToAngleAxis(rotation.data(), numbers.data());
  std::copy_n(translation.data(), 3, numbers.begin() + 3);
  return numbers;
}

Eigen::Isometry3d pose_of(const PoseNumbers& numbers) {
  Eigen::Matrix3d rotation;
  ceres::AngleAxisToRotationMatrix(numbers.data(), rotation.data());
  return Eigen::Translation3d(numbers[3], numbers[4], numbers[5]) * Eigen::Isometry3d(rotation);
}

void set_lens(Lens& lens, const LensNumbers& numbers) {
  lens.intrinsic << numbers[0], 0, numbers[2], 0, numbers[1], numbers[3], 0, 0, 1;
  std::copy(numbers.begin() + 4, numbers.end(), lens.distortion.coefficients.begin());
}

void Adjustment::hold(double* block) {
  if (problem_.HasParameterBlock(block)) problem_.SetParameterBlockConstant(block);
}

void Adjustment::settle_lens(LensNumbers& lens, bool held, int coefficients) {
  if (!problem_.HasParameterBlock(lens.data())) return;
  if (held) return hold(lens.data());

  std::vector<int> constant;
  for (int i = 4 + coefficients; i < lens_number_count; ++i) constant.push_back(i);
  if (constant.empty()) return;

  manifolds_.push_back(std::make_unique<ceres::SubsetManifold>(lens_number_count, constant));
  problem_.SetManifold(lens.data(), manifolds_.back().get());
}

void Adjustment::settle_places(BoardPlaces& places, const BoardPlaces& printed,
                               const std::optional<double>& deviation) {
  for (std::size_t i = 0; i < printed.size(); ++i) {
    double* place = places[i].data();
    if (!deviation) {
      hold(place);
    } else if (problem_.HasParameterBlock(place)) {
      add(std::make_unique<PrintError>(printed[i], *deviation), false, place);
    }
  }
}

void Adjustment::solve(double tolerance) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = tolerance;
  options.logging_type = ceres::SILENT;

  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  throw_if(!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost),
           "bundle adjustment did not converge; likely corners that contradict each other: check "
           "`board` and `corners`");
}

std::optional<Eigen::VectorXd> Adjustment::deviations_of(
    const std::vector<std::pair<double*, int>>& blocks) {
  // 1. The columns of the free parameters in the Jacobian.
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;

  std::vector<double*> all;
  problem_.GetParameterBlocks(&all);
  std::map<const double*, int> first_column;
  int columns = 0;

  for (double* block : all) {
    if (problem_.IsParameterBlockConstant(block)) continue;
    options.parameter_blocks.push_back(block);
    first_column[block] = columns;
    columns += problem_.ParameterBlockTangentSize(block);
  }

  // 2. The variances of all free parameters together.
  ceres::CRSMatrix jacobian;
  if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) return std::nullopt;
  const std::optional<Eigen::VectorXd> variances = variances_of(jacobian);
  if (!variances) return std::nullopt;

  // 3. Those of the wanted blocks; 0 if held.
  int size = 0;
  for (const auto& [block, length] : blocks) size += length;
  Eigen::VectorXd deviations = Eigen::VectorXd::Zero(size);

  int first = 0;
  for (const auto& [block, length] : blocks) {
    if (const auto found = first_column.find(block); found != first_column.end()) {
      const int free = problem_.ParameterBlockTangentSize(block);
      deviations.segment(first, free) = variances->segment(found->second, free).cwiseSqrt();
    }
    first += length;
  }
  return deviations;
}

}  // namespace slipstream
