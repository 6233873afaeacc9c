#include "calibrate/hand_eye_adjustment.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Cholesky>
#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "calibrate/quiet_ceres.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Rotation and translation, of plain numbers or of Ceres' numbers with derivatives.
template <class Number>
struct MovedFrame {
  Eigen::Matrix<Number, 3, 3> rotation;
  Eigen::Matrix<Number, 3, 1> translation;
};

/// The pose turned in its own frame and moved in the other by six numbers.
template <class Number>
MovedFrame<Number> moved(const Eigen::Isometry3d& pose, const Number* by) {
  Eigen::Matrix<Number, 3, 3> turn;
  ceres::AngleAxisToRotationMatrix(by, turn.data());
  const Eigen::Matrix3d rotation = pose.linear();
  const Eigen::Vector3d translation = pose.translation();
  return {rotation.cast<Number>() * turn,
          translation.cast<Number>() + Eigen::Map<const Eigen::Matrix<Number, 3, 1>>(by + 3)};
}

/// The board's carrier in the frame of the camera's.
Eigen::Isometry3d between_carriers(const Eigen::Isometry3d& robot, EyePlace place) {
  return place == EyePlace::in_hand ? robot.inverse() : robot;
}

/// Error of a pair, whitened, as a function of the changes of both poses.
class PairResidual {
 public:
  PairResidual(const PosePair& pair, const HandEyePoses& poses, EyePlace place,
               const Matrix6& whitening)
      : board_(pair.board),
        between_(between_carriers(pair.robot, place)),
        poses_(poses),
        whitening_(whitening) {}

  template <class Number>
  bool operator()(const Number* camera_by, const Number* board_by, Number* residuals) const {
    using Vector = Eigen::Matrix<Number, 3, 1>;
    const MovedFrame<Number> camera = moved(poses_.camera, camera_by);
    const MovedFrame<Number> board = moved(poses_.board, board_by);

    // The predicted board: through both carriers into the camera's frame.
    const Eigen::Matrix3d between = between_.linear();
    const Eigen::Vector3d offset = between_.translation();
    const Eigen::Matrix<Number, 3, 3> rotation =
        camera.rotation.transpose() * between.cast<Number>() * board.rotation;
    const Vector carried = between.cast<Number>() * board.translation + offset.cast<Number>();
    const Vector translation = camera.rotation.transpose() * (carried - camera.translation);

    // Measured less predicted.
    const Eigen::Matrix3d measured = board_.linear();
    const Eigen::Vector3d place = board_.translation();
    const Eigen::Matrix<Number, 3, 3> turn = measured.cast<Number>() * rotation.transpose();
    Eigen::Matrix<Number, 6, 1> error;
    ceres::RotationMatrixToAngleAxis(turn.data(), error.data());
    error.template tail<3>() = place.cast<Number>() - translation;

    Eigen::Map<Eigen::Matrix<Number, 6, 1>>{residuals} = whitening_.cast<Number>() * error;
    return true;
  }

 private:
  Eigen::Isometry3d board_, between_;
  HandEyePoses poses_;
  Matrix6 whitening_;
};

using PairCost = ceres::AutoDiffCostFunction<PairResidual, 6, 6, 6>;

Matrix6 whitening_of(const Matrix6& covariance) {
  const Matrix6 factor = covariance.llt().matrixL();
  return factor.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
}

/// The effect of an error of the robot's pose, in the tool's frame, on the pair's error.
Matrix6 robot_effect(const PosePair& pair, const HandEyePoses& poses, EyePlace place) {
  const Eigen::Matrix3d from_base = poses.camera.linear().transpose();

  Eigen::Matrix3d from_tool = from_base;
  Eigen::Vector3d board = (pair.robot.inverse() * poses.board).translation();
  if (place == EyePlace::to_hand) {
    from_tool = from_base * pair.robot.linear();
    board = poses.board.translation();
  }

  // A turn of the tool moves the board by its distance from the tool.
  Matrix6 effect;
  effect << from_tool, Eigen::Matrix3d::Zero(), -from_tool * cross_matrix(board), from_tool;
  return effect;
}

PoseError robot_variances(const HandEyeScatter& scatter) {
  PoseError deviations;
  deviations << Eigen::Vector3d::Constant(scatter.robot_rotation),
      Eigen::Vector3d::Constant(scatter.robot_translation);
  return deviations.cwiseAbs2();
}

PoseError board_variances(const HandEyeScatter& scatter) {
  PoseError deviations;
  deviations << scatter.board_tilt, scatter.board_tilt, scatter.board_roll, scatter.board_across,
      scatter.board_across, scatter.board_depth;
  return deviations.cwiseAbs2();
}

/// The scatter of these variances, at least so large that a perfect robot has finite weights.
HandEyeScatter scatter_of(const PoseError& robot, const PoseError& board) {
  constexpr double least_rotation = 1e-7, least_translation = 1e-4;  // rad, mm
  const auto rotation = [&](double variance) {
    return std::max(std::sqrt(std::max(variance, 0.0)), least_rotation);
  };
  const auto translation = [&](double variance) {
    return std::max(std::sqrt(std::max(variance, 0.0)), least_translation);
  };

  return {.robot_rotation = rotation(robot.head<3>().mean()),
          .robot_translation = translation(robot.tail<3>().mean()),
          .board_tilt = rotation(board.head<2>().mean()),
          .board_roll = rotation(board[2]),
          .board_across = translation(board.segment<2>(3).mean()),
          .board_depth = translation(board[5])};
}

Matrix6 covariance_with(const Matrix6& effect, const HandEyeScatter& scatter) {
  Matrix6 covariance = effect * robot_variances(scatter).asDiagonal() * effect.transpose();
  covariance.diagonal() += board_variances(scatter);
  return covariance;
}

/// Splits the errors between robot and camera.
HandEyeScatter estimated_scatter(std::span<const PosePair> pairs, const HandEyePoses& poses,
                                 EyePlace place) {
  constexpr int rounds = 40;
  const auto count = static_cast<double>(pairs.size());
  const double freedom = std::max(count - 2, 1.0);  // two poses are fitted to them

  // 1. All errors once as the robot's and once as the camera's; half of each to begin with.
  std::vector<Matrix6> effects;
  std::vector<PoseError> errors;
  PoseError robot = PoseError::Zero(), board = PoseError::Zero();
  for (const PosePair& pair : pairs) {
    effects.push_back(robot_effect(pair, poses, place));
    errors.push_back(error_of(pair, poses, place));
    board += errors.back().cwiseAbs2() / (2 * freedom);
    const PoseError of_robot = effects.back().inverse() * errors.back();
    robot += of_robot.cwiseAbs2() / (2 * freedom);
  }

  // 2. Expectation maximisation: the expected square of each part, given their sum.
  HandEyeScatter scatter = scatter_of(robot, board);
  for (int round = 0; round < rounds; ++round) {
    const PoseError of_robot = robot_variances(scatter), of_board = board_variances(scatter);
    robot.setZero();
    board.setZero();

    for (std::size_t i = 0; i < errors.size(); ++i) {
      const Matrix6 weight = inverse_of(covariance_with(effects[i], scatter));
      const Matrix6 carried = effects[i].transpose() * weight * effects[i];
      const PoseError share = weight * errors[i];
      const PoseError robot_share = effects[i].transpose() * share;

      robot += (of_robot.cwiseProduct(robot_share).cwiseAbs2() / freedom) +
               (of_robot - of_robot.cwiseAbs2().cwiseProduct(carried.diagonal())) / count;
      board += (of_board.cwiseProduct(share).cwiseAbs2() / freedom) +
               (of_board - of_board.cwiseAbs2().cwiseProduct(weight.diagonal())) / count;
    }
    scatter = scatter_of(robot, board);
  }
  return scatter;
}

/// One adjustment with fixed weights.
HandEyePoses solved(std::span<const PosePair> pairs, const HandEyePoses& start, EyePlace place,
                    const HandEyeScatter& scatter) {
  constexpr double huber_reach = 6;  // of the length of six errors in standard deviations
  ceres::HuberLoss huber(huber_reach);
  ceres::Problem problem({.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP,
                          .loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP});

  // Owned here: the problem would leak them when memory runs out.
  std::vector<std::unique_ptr<PairCost>> costs;
  PoseError camera = PoseError::Zero(), board = PoseError::Zero();
  for (const PosePair& pair : pairs) {
    const Matrix6 whitening = whitening_of(covariance_of(pair, start, place, scatter));
    costs.push_back(std::make_unique<PairCost>(new PairResidual(pair, start, place, whitening)));
    problem.AddResidualBlock(costs.back().get(), &huber, camera.data(), board.data());
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-10;
  options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;

  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  throw_if(!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost),
           "the hand-eye adjustment did not converge: the poses contradict each other");

  const auto result = [](const Eigen::Isometry3d& pose, const PoseError& by) {
    const MovedFrame<double> frame = moved(pose, by.data());
    return pose_from(frame.rotation, frame.translation);
  };
  return {result(start.camera, camera), result(start.board, board)};
}

/// Inverse of the weighted normal equations.
Eigen::Matrix<double, 12, 12> covariance_of_poses(std::span<const PosePair> pairs,
                                                  const HandEyePoses& poses, EyePlace place,
                                                  const HandEyeScatter& scatter) {
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (const PosePair& pair : pairs) {
    const PairDerivatives by = derivatives_of(pair, poses, place);
    normal += by.transpose() * Matrix6(inverse_of(covariance_of(pair, poses, place, scatter))) * by;
  }

  // Scale away the units. A tiny pivot means a combination that the poses leave free.
  constexpr double least_pivot = 1e-12;
  const Eigen::Matrix<double, 12, 1> scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const auto inverse =
      inverse_of_symmetric(scale.asDiagonal() * normal * scale.asDiagonal(), least_pivot);
  throw_if(!inverse, "the poses do not determine the hand-eye pose: turn the tool about two axes");

  return scale.asDiagonal() * *inverse * scale.asDiagonal();
}

}  // namespace

Eigen::Isometry3d robot_for(const Eigen::Isometry3d& board, const HandEyePoses& poses,
                            EyePlace place) {
  if (place == EyePlace::in_hand) return poses.board * board.inverse() * poses.camera.inverse();
  return poses.camera * board * poses.board.inverse();
}

PoseError error_of(const PosePair& pair, const HandEyePoses& poses, EyePlace place) {
  const Eigen::Isometry3d predicted =
      poses.camera.inverse() * between_carriers(pair.robot, place) * poses.board;
  PoseError error;
  error << vector_of(pair.board.linear() * predicted.linear().transpose()),
      pair.board.translation() - predicted.translation();
  return error;
}

PairDerivatives derivatives_of(const PosePair& pair, const HandEyePoses& poses, EyePlace place) {
  const PairCost cost(new PairResidual(pair, poses, place, Matrix6::Identity()));
  const PoseError unmoved = PoseError::Zero();
  const double* const at[] = {unmoved.data(), unmoved.data()};

  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> by_camera, by_board;
  double* by[] = {by_camera.data(), by_board.data()};
  PoseError error;
  cost.Evaluate(at, error.data(), by);

  PairDerivatives derivatives;
  derivatives << by_camera, by_board;
  return derivatives;
}

Eigen::Matrix<double, 6, 6> covariance_of(const PosePair& pair, const HandEyePoses& poses,
                                          EyePlace place, const HandEyeScatter& scatter) {
  return covariance_with(robot_effect(pair, poses, place), scatter);
}

AdjustedHandEye adjusted_hand_eye(std::span<const PosePair> pairs, const HandEyePoses& start,
                                  EyePlace place) {
  const QuietCeres quiet;
  constexpr int rounds = 3;

  // Weights follow from the scatter about the solution, so both are found in turn.
  HandEyePoses poses = start;
  HandEyeScatter scatter;
  for (int round = 0; round < rounds; ++round) {
    scatter = estimated_scatter(pairs, poses, place);
    poses = solved(pairs, poses, place, scatter);
  }

  scatter = estimated_scatter(pairs, poses, place);
  return {poses, covariance_of_poses(pairs, poses, place, scatter), scatter};
}

}  // namespace slipstream
