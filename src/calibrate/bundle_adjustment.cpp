#include "calibrate/bundle_adjustment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include "base/throw_if-inl.h"
#include "calibrate/board_view.h"
#include "calibrate/pixel_derivatives.h"
#include "calibrate/quiet_ceres.h"
#include "calibrate/reprojection.h"

namespace slipstream {
namespace {

constexpr int lens_size = lens_number_count;
using LensNumbers = std::array<double, lens_size>;  ///< fx fy cx cy, distortion
using PoseNumbers = std::array<double, 6>;          ///< axis times angle, translation

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

/// Camera, projector and their relative pose, concatenated.
using RigNumbers = Eigen::Matrix<double, 2 * lens_size + 6, 1>;

RigNumbers numbers_of(const Scanner& scanner) {
  RigNumbers numbers;
  double* next = numbers.data();
  next = std::ranges::copy(numbers_of(scanner.camera), next).out;
  next = std::ranges::copy(numbers_of(scanner.projector), next).out;
  std::ranges::copy(numbers_of(scanner.rotation, scanner.translation), next);
  return numbers;
}

/// Calls `use` with each number of a deviation and the corresponding number of a row.
template <class Use>
void with_row(BundleDeviation& deviation, const RigNumbers& row, const Use& use) {
  const double* next = row.data();
  const auto each = [&](auto& values) {
    for (double& value : values) use(value, *next++);
  };

  for (auto* lens : {&deviation.camera, &deviation.projector}) {
    each(lens->focal);
    each(lens->principal_point);
    each(lens->coefficients);
  }
  each(deviation.rotation);
  each(deviation.translation);
}

/// Sets a parameter's block of the Jacobian if Ceres requests it.
template <int Columns, class Derivative>
void set_block(double** jacobians, int block, const Derivative& derivative) {
  using Block = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Columns, Eigen::RowMajor>>;
  if (jacobians == nullptr || jacobians[block] == nullptr) return;
  Block(jacobians[block], derivative.rows(), Columns) = derivative;
}

/// Camera residual of a corner, in standard deviations. Parameters: lens, pose, place.
class CameraError : public ceres::SizedCostFunction<2, lens_size, 6, 3> {
 public:
  CameraError(Eigen::Vector2d seen, double deviation)  // pixels
      : seen_(std::move(seen)), deviation_(deviation) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const MovedPoint in_camera =
        moved_point(parameters[1], Eigen::Map<const Eigen::Vector3d>(parameters[2]));
    const SeenPoint predicted = seen_point(parameters[0], in_camera.point);
    Eigen::Map<Eigen::Vector2d>{residuals} = (seen_ - predicted.pixel) / deviation_;
    if (jacobians == nullptr) return true;

    // By the chain rule: pixel by camera point, camera point by pose and place.
    const Eigen::Matrix<double, 2, 3> by_point = -predicted.by_point / deviation_;
    set_block<lens_size>(jacobians, 0, -predicted.by_lens / deviation_);
    set_block<6>(jacobians, 1, by_point * in_camera.by_pose);
    set_block<3>(jacobians, 2, by_point * in_camera.by_point);
    return true;
  }

 private:
  Eigen::Vector2d seen_;
  double deviation_;
};

/// Camera and projector residual of a corner, in standard deviations; the projector's without the
/// part that the camera's causes. Parameters: camera, projector, rig, pose, place.
class PairError : public ceres::SizedCostFunction<4, lens_size, lens_size, 6, 6, 3> {
 public:
  PairError(Eigen::Vector2d camera_seen, Eigen::Vector2d projector_seen,
            const Eigen::Matrix2d& slope, const PixelDeviations& deviations)
      : camera_seen_(std::move(camera_seen)), projector_seen_(std::move(projector_seen)) {
    // From pixel distances to residuals: subtracts the camera's part, divides by the deviations.
    to_residuals_ << Eigen::Matrix2d::Identity() / deviations.camera, Eigen::Matrix2d::Zero(),
        -slope / deviations.projector, Eigen::Matrix2d::Identity() / deviations.projector;
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const MovedPoint in_camera =
        moved_point(parameters[3], Eigen::Map<const Eigen::Vector3d>(parameters[4]));
    const MovedPoint in_projector = moved_point(parameters[2], in_camera.point);
    const SeenPoint camera = seen_point(parameters[0], in_camera.point);
    const SeenPoint projector = seen_point(parameters[1], in_projector.point);

    Eigen::Vector4d distances;
    distances << camera_seen_ - camera.pixel, projector_seen_ - projector.pixel;
    Eigen::Map<Eigen::Vector4d>{residuals} = to_residuals_ * distances;
    if (jacobians == nullptr) return true;

    // By the chain rule; the pose and the place move the point in both devices' frames.
    const Eigen::Matrix<double, 4, 2> by_camera = -to_residuals_.leftCols<2>();
    const Eigen::Matrix<double, 4, 2> by_projector = -to_residuals_.rightCols<2>();
    const Eigen::Matrix<double, 4, 3> by_projector_point = by_projector * projector.by_point;
    const Eigen::Matrix<double, 4, 3> by_point =
        by_camera * camera.by_point + by_projector_point * in_projector.by_point;

    set_block<lens_size>(jacobians, 0, by_camera * camera.by_lens);
    set_block<lens_size>(jacobians, 1, by_projector * projector.by_lens);
    set_block<6>(jacobians, 2, by_projector_point * in_projector.by_pose);
    set_block<6>(jacobians, 3, by_point * in_camera.by_pose);
    set_block<3>(jacobians, 4, by_point * in_camera.by_point);
    return true;
  }

 private:
  Eigen::Vector2d camera_seen_, projector_seen_;
  Eigen::Matrix4d to_residuals_;
};

/// Projector residual of a corner that the camera does not see, in standard deviations. Parameters:
/// projector, rig, pose, place.
class ProjectorError : public ceres::SizedCostFunction<2, lens_size, 6, 6, 3> {
 public:
  ProjectorError(Eigen::Vector2d seen, double deviation)  // pixels
      : seen_(std::move(seen)), deviation_(deviation) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const MovedPoint in_camera =
        moved_point(parameters[2], Eigen::Map<const Eigen::Vector3d>(parameters[3]));
    const MovedPoint in_projector = moved_point(parameters[1], in_camera.point);
    const SeenPoint predicted = seen_point(parameters[0], in_projector.point);
    Eigen::Map<Eigen::Vector2d>{residuals} = (seen_ - predicted.pixel) / deviation_;
    if (jacobians == nullptr) return true;

    const Eigen::Matrix<double, 2, 3> by_projector_point = -predicted.by_point / deviation_;
    const Eigen::Matrix<double, 2, 3> by_point = by_projector_point * in_projector.by_point;
    set_block<lens_size>(jacobians, 0, -predicted.by_lens / deviation_);
    set_block<6>(jacobians, 1, by_projector_point * in_projector.by_pose);
    set_block<6>(jacobians, 2, by_point * in_camera.by_pose);
    set_block<3>(jacobians, 3, by_point * in_camera.by_point);
    return true;
  }

 private:
  Eigen::Vector2d seen_;
  double deviation_;
};

/// Printing error of a corner, in standard deviations.
class PrintError : public ceres::SizedCostFunction<3, 3> {
 public:
  PrintError(Eigen::Vector3d printed, double deviation)  // mm
      : printed_(std::move(printed)), deviation_(deviation) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> place(parameters[0]);
    Eigen::Map<Eigen::Vector3d>{residuals} = (place - printed_) / deviation_;
    set_block<3>(jacobians, 0, Eigen::Matrix3d::Identity() / deviation_);
    return true;
  }

 private:
  Eigen::Vector3d printed_;
  double deviation_;
};

/// The parameters of a BundleState, as Ceres adjusts them.
struct Parameters {
  explicit Parameters(const BundleState& state)
      : camera(numbers_of(state.scanner.camera)),
        projector(numbers_of(state.scanner.projector)),
        rig(numbers_of(state.scanner.rotation, state.scanner.translation)),
        places(state.places) {
    for (const Eigen::Isometry3d& pose : state.poses) {
      poses.push_back(numbers_of(pose.linear(), pose.translation()));
    }
  }

  void write_to(BundleState& state) const {
    set_lens(state.scanner.camera, camera);
    set_lens(state.scanner.projector, projector);

    const Eigen::Isometry3d to_projector = pose_of(rig);
    state.scanner.rotation = to_projector.linear();
    state.scanner.translation = to_projector.translation();

    for (std::size_t i = 0; i < poses.size(); ++i) state.poses[i] = pose_of(poses[i]);
    state.places = places;
  }

  LensNumbers camera, projector;
  PoseNumbers rig;
  std::vector<PoseNumbers> poses;
  BoardPlaces places;
};

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
  const Eigen::LDLT<Eigen::MatrixXd> factors(scaled);
  constexpr double least_pivot = 1e-13;
  if (!(factors.vectorD().minCoeff() > least_pivot)) return std::nullopt;

  const Eigen::MatrixXd inverse =
      factors.solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
  return inverse.diagonal().cwiseProduct(scale.cwiseAbs2());
}

constexpr double huber_reach = 3;  // standard deviations

class BundleProblem {
 public:
  BundleProblem(const BoardViews& views, const BundleState& state, const BoardPlaces& printed,
                const BundleSettings& settings, const PixelDeviations& deviations)
      : parameters_(state) {
    for (std::size_t v = 0; v < views.size(); ++v) add_view(views[v], v, deviations);
    settle_lens(parameters_.camera, settings.hold_camera, settings.camera_coefficients);
    settle_lens(parameters_.projector, settings.hold_projector, settings.projector_coefficients);

    if (settings.hold_rig) hold(parameters_.rig.data());
    settle_places(printed, settings.print_deviation);
  }

  void solve(double tolerance) {
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

  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

  /// Returns false if the data do not determine the parameters.
  bool estimate(BundleDeviation& deviation) {
    // 1. The columns of the free parameters in the Jacobian.
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;

    std::vector<double*> blocks;
    problem_.GetParameterBlocks(&blocks);
    std::map<const double*, int> first_column;
    int columns = 0;

    for (double* block : blocks) {
      if (problem_.IsParameterBlockConstant(block)) continue;
      options.parameter_blocks.push_back(block);
      first_column[block] = columns;
      columns += problem_.ParameterBlockTangentSize(block);
    }

    // 2. The variances of all free parameters together.
    ceres::CRSMatrix jacobian;
    if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) return false;
    const std::optional<Eigen::VectorXd> variances = variances_of(jacobian);
    if (!variances) return false;

    // 3. The standard deviations of lenses and rig, in the order of RigNumbers; 0 if held.
    RigNumbers deviations = RigNumbers::Zero();
    const auto put = [&](const double* block, int first) {
      const auto found = first_column.find(block);
      if (found == first_column.end()) return;
      const int free = problem_.ParameterBlockTangentSize(block);
      deviations.segment(first, free) = variances->segment(found->second, free).cwiseSqrt();
    };

    put(parameters_.camera.data(), 0);
    put(parameters_.projector.data(), lens_size);
    put(parameters_.rig.data(), 2 * lens_size);
    with_row(deviation, deviations, [](double& value, double number) { value = number; });

    return true;
  }

 private:
  void add_view(const BoardView& view, std::size_t v, const PixelDeviations& deviations) {
    for (std::size_t i = 0; i < view.places.size(); ++i) {
      double* place = parameters_.places[view.places[i]].data();
      double* pose = parameters_.poses[v].data();

      // A corner that one device sees still determines the pose and that device's lens.
      if (is_lit(view, i)) {
        problem_.AddResidualBlock(
            owned(std::make_unique<PairError>(view.camera[i], view.projector[i], slope_at(view, i),
                                              deviations)),
            &huber_, parameters_.camera.data(), parameters_.projector.data(),
            parameters_.rig.data(), pose, place);
      } else if (view.camera[i].allFinite()) {
        auto* error = owned(std::make_unique<CameraError>(view.camera[i], deviations.camera));
        problem_.AddResidualBlock(error, &huber_, parameters_.camera.data(), pose, place);
      } else if (view.projector[i].allFinite()) {
        problem_.AddResidualBlock(
            owned(std::make_unique<ProjectorError>(view.projector[i], deviations.projector)),
            &huber_, parameters_.projector.data(), parameters_.rig.data(), pose, place);
      }
    }
  }

  void hold(double* block) {
    if (problem_.HasParameterBlock(block)) problem_.SetParameterBlockConstant(block);
  }

  void settle_lens(LensNumbers& lens, bool held, int coefficients) {
    if (!problem_.HasParameterBlock(lens.data())) return;
    if (held) return hold(lens.data());

    std::vector<int> constant;
    for (int i = 4 + coefficients; i < lens_size; ++i) constant.push_back(i);
    if (constant.empty()) return;

    manifolds_.push_back(std::make_unique<ceres::SubsetManifold>(lens_size, constant));
    problem_.SetManifold(lens.data(), manifolds_.back().get());
  }

  void settle_places(const BoardPlaces& printed, const std::optional<double>& deviation) {
    for (std::size_t i = 0; i < printed.size(); ++i) {
      double* place = parameters_.places[i].data();
      if (!deviation) {
        hold(place);
      } else if (problem_.HasParameterBlock(place)) {
        problem_.AddResidualBlock(owned(std::make_unique<PrintError>(printed[i], *deviation)),
                                  nullptr, place);
      }
    }
  }

  ceres::CostFunction* owned(std::unique_ptr<ceres::CostFunction> error) {
    return errors_.emplace_back(std::move(error)).get();
  }

  Parameters parameters_;
  // Owned here: the problem would leak them when memory runs out.
  std::vector<std::unique_ptr<ceres::CostFunction>> errors_;
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;
  ceres::HuberLoss huber_{huber_reach};
  ceres::Problem problem_{
      ceres::Problem::Options{.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP,
                              .loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP,
                              .manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP}};
};

}  // namespace

BoardViews without_residual(BoardViews views, const Scanner& scanner) {
  for (BoardView& view : views) {
    for (Eigen::Vector2d& pixel : view.camera) pixel -= shift_at(scanner.camera.residual, pixel);
    for (Eigen::Vector2d& pixel : view.projector) {
      pixel -= shift_at(scanner.projector.residual, pixel);
    }
  }
  return views;
}

void forget_held_coefficients(Scanner& scanner, const BundleSettings& settings) {
  const auto forget = [](Lens& lens, int free) {
    auto& k = lens.distortion.coefficients;
    std::fill(k.begin() + free, k.end(), 0.0);
  };
  forget(scanner.camera, settings.camera_coefficients);
  forget(scanner.projector, settings.projector_coefficients);
}

BundleState bundle_adjusted(const BoardViews& seen, BundleState start, const BoardPlaces& printed,
                            const BundleSettings& settings, BundleDeviation* deviation) {
  const QuietCeres quiet;

  // The problem's lenses have no residual maps: shift the corners instead, and put the maps back at
  // the end.
  const BoardViews views = without_residual(seen, start.scanner);
  const LensResidual of_camera = std::exchange(start.scanner.camera.residual, {});
  const LensResidual of_projector = std::exchange(start.scanner.projector.residual, {});
  const int rounds = settings.pixel_deviations ? 1 : 3;

  BundleState state = std::move(start);
  PixelDeviations deviations = settings.pixel_deviations.value_or(pixel_deviations(views, state));

  for (int round = 0; round < rounds; ++round) {
    BundleProblem problem(views, state, printed, settings, deviations);

    problem.solve(settings.pixel_deviations ? 1e-7 : 1e-9);  // first solution or refinement
    problem.parameters().write_to(state);
    deviations = pixel_deviations(views, state);

    throw_if(
        round + 1 == rounds && deviation != nullptr && !problem.estimate(*deviation),
        "the poses do not determine the calibration; likely too few tilts of the board: tilt it "
        "differently in each");
  }

  state.scanner.camera.residual = of_camera;
  state.scanner.projector.residual = of_projector;
  return state;
}

BundleDeviation widened(BundleDeviation deviation, const std::vector<Scanner>& without_one) {
  const auto m = static_cast<double>(without_one.size());

  RigNumbers mean = RigNumbers::Zero(), squares = RigNumbers::Zero();
  for (const Scanner& scanner : without_one) mean += numbers_of(scanner) / m;
  for (const Scanner& scanner : without_one) squares += (numbers_of(scanner) - mean).cwiseAbs2();

  const RigNumbers jackknife = ((m - 1) / m * squares).cwiseSqrt();
  with_row(deviation, jackknife,
           [](double& value, double number) { value = std::max(value, number); });
  return deviation;
}

}  // namespace slipstream
