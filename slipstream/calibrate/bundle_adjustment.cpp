// The one source that sees Ceres.
#include "slipstream/calibrate/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include "slipstream/error/error.h"
#include "slipstream/geometry/distortion_formula.h"

namespace slipstream {
namespace {

constexpr int lens_size = 4 + untilted_coefficient_count;
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
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = Eigen::Vector3d(numbers[3], numbers[4], numbers[5]);
  return pose;
}

void set_lens(Lens& lens, const LensNumbers& numbers) {
  lens.intrinsic << numbers[0], 0, numbers[2], 0, numbers[1], numbers[3], 0, 0, 1;
  std::copy(numbers.begin() + 4, numbers.end(), lens.distortion.coefficients.begin());
}

/// Where a device sees a corner: from the board to the camera, from there to the device, through
/// its lens. One form for both devices, so that it is compiled once.
struct ReprojectionError {
  Eigen::Vector2d seen;
  double deviation;  ///< pixels

  template <class T>
  bool operator()(const T* lens, const T* device, const T* pose, const T* place,
                  T* residual) const {
    std::array<T, 3> in_camera, in_device;
    moved(pose, place, in_camera.data());
    moved(device, in_camera.data(), in_device.data());
    const Eigen::Matrix<T, 2, 1> direction(in_device[0] / in_device[2],
                                           in_device[1] / in_device[2]);
    const Eigen::Matrix<T, 2, 1> bent = distort_untilted(lens + 4, direction);
    residual[0] = (lens[0] * bent.x() + lens[2] - seen.x()) / deviation;
    residual[1] = (lens[1] * bent.y() + lens[3] - seen.y()) / deviation;
    return true;
  }

  template <class T>
  static void moved(const T* pose, const T* point, T* result) {
    ceres::AngleAxisRotatePoint(pose, point, result);
    for (int i = 0; i < 3; ++i) result[i] += pose[3 + i];
  }
};

/// How far a corner lies from where it should be printed.
struct PrintError {
  Eigen::Vector3d printed;
  double deviation;  ///< mm

  template <class T>
  bool operator()(const T* place, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = (place[i] - printed[i]) / deviation;
    return true;
  }
};

/// The parameters of a BundleState as Ceres moves them.
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
  PoseNumbers camera_itself{};  ///< the camera's frame in its own: held
  std::vector<PoseNumbers> poses;
  std::vector<Eigen::Vector3d> places;
};

/// Standard deviations of the pixels, per device.
struct PixelDeviations {
  double camera = 1;
  double projector = 1;
};

/// While any lives, Ceres logs nothing: a step that fails is tried again smaller, and a library
/// does not write to its caller's terminal.
class QuietCeres {
 public:
  QuietCeres() {
    const std::scoped_lock lock(mutex);
    if (living++ > 0) return;
    level_before = FLAGS_minloglevel;
    FLAGS_minloglevel = google::GLOG_FATAL;
  }
  QuietCeres(const QuietCeres&) = delete;
  QuietCeres& operator=(const QuietCeres&) = delete;
  ~QuietCeres() {
    const std::scoped_lock lock(mutex);
    if (--living == 0) FLAGS_minloglevel = level_before;
  }

 private:
  // The level is one for the whole process.
  static inline std::mutex mutex;
  static inline int living = 0;
  static inline int level_before = 0;
};

constexpr double huber_reach = 2.5;  // standard deviations

class BundleProblem {
 public:
  BundleProblem(const std::vector<BoardView>& views, const BundleState& state,
                const std::vector<Eigen::Vector3d>& printed, const BundleSettings& settings,
                const PixelDeviations& deviations)
      : parameters_(state) {
    for (std::size_t v = 0; v < views.size(); ++v) add_view(views[v], v, deviations);
    hold(parameters_.camera_itself.data());
    settle_lens(parameters_.camera, settings.hold_camera, settings.camera_coefficients);
    settle_lens(parameters_.projector, settings.hold_projector, settings.projector_coefficients);
    settle_places(printed, settings.print_deviation);
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-9;
    options.parameter_tolerance = 1e-9;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) {
      throw Error("bundle adjustment found no solution; the corners contradict one another");
    }
  }

  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

  /// False where the data do not determine the parameters.
  bool estimate(BundleDeviation& deviation) {
    ceres::Covariance::Options options;
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    const std::array<const double*, 3> blocks{parameters_.camera.data(),
                                              parameters_.projector.data(), parameters_.rig.data()};
    std::vector<std::pair<const double*, const double*>> wanted;
    for (const double* block : blocks) {
      if (problem_.HasParameterBlock(block)) wanted.emplace_back(block, block);
    }
    if (!covariance.Compute(wanted, &problem_)) return false;
    deviation.camera = lens_deviation(covariance, parameters_.camera);
    deviation.projector = lens_deviation(covariance, parameters_.projector);
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> rig;
    covariance.GetCovarianceBlock(blocks[2], blocks[2], rig.data());
    deviation.rotation = rig.diagonal().head<3>().cwiseSqrt();
    deviation.translation = rig.diagonal().tail<3>().cwiseSqrt();
    return true;
  }

 private:
  void add_view(const BoardView& view, std::size_t v, const PixelDeviations& deviations) {
    for (std::size_t i = 0; i < view.places.size(); ++i) {
      double* place = parameters_.places[static_cast<std::size_t>(view.places[i])].data();
      double* pose = parameters_.poses[v].data();
      if (view.camera[i].allFinite()) {
        add(view.camera[i], deviations.camera, parameters_.camera.data(),
            parameters_.camera_itself.data(), pose, place);
      }
      if (view.projector[i].allFinite()) {
        add(view.projector[i], deviations.projector, parameters_.projector.data(),
            parameters_.rig.data(), pose, place);
      }
    }
  }

  void add(const Eigen::Vector2d& seen, double deviation, double* lens, double* device,
           double* pose, double* place) {
    using Cost = ceres::AutoDiffCostFunction<ReprojectionError, 2, lens_size, 6, 6, 3>;
    problem_.AddResidualBlock(new Cost(new ReprojectionError{seen, deviation}),
                              new ceres::HuberLoss(huber_reach), lens, device, pose, place);
  }

  void hold(double* block) {
    if (problem_.HasParameterBlock(block)) problem_.SetParameterBlockConstant(block);
  }

  void settle_lens(LensNumbers& lens, bool held, int coefficients) {
    if (!problem_.HasParameterBlock(lens.data())) return;
    if (held) return hold(lens.data());
    std::vector<int> constant;
    for (int i = 4 + coefficients; i < lens_size; ++i) constant.push_back(i);
    if (!constant.empty()) {
      problem_.SetManifold(lens.data(), new ceres::SubsetManifold(lens_size, constant));
    }
  }

  void settle_places(const std::vector<Eigen::Vector3d>& printed,
                     const std::optional<double>& deviation) {
    for (std::size_t i = 0; i < printed.size(); ++i) {
      double* place = parameters_.places[i].data();
      if (!problem_.HasParameterBlock(place)) continue;
      if (!deviation) {
        hold(place);
        continue;
      }
      using Cost = ceres::AutoDiffCostFunction<PrintError, 3, 3>;
      problem_.AddResidualBlock(new Cost(new PrintError{printed[i], *deviation}), nullptr, place);
    }
  }

  LensDeviation lens_deviation(const ceres::Covariance& covariance, const LensNumbers& lens) {
    LensDeviation deviation;
    if (!problem_.HasParameterBlock(lens.data())) return deviation;
    Eigen::Matrix<double, lens_size, lens_size, Eigen::RowMajor> block;
    covariance.GetCovarianceBlock(lens.data(), lens.data(), block.data());
    const Eigen::Matrix<double, lens_size, 1> each = block.diagonal().cwiseMax(0).cwiseSqrt();
    deviation.focal = each.head<2>();
    deviation.principal_point = each.segment<2>(2);
    std::copy_n(each.data() + 4, untilted_coefficient_count, deviation.coefficients.begin());
    return deviation;
  }

  Parameters parameters_;
  ceres::Problem problem_;
};

/// Standard deviation of the components, by the median of their sizes.
double robust_deviation(std::vector<double> sizes) {
  if (sizes.empty()) return 1;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  constexpr double least = 1e-3;  // pixels: noise-free pictures must not weigh without bound
  return std::max(1.4826 * *middle, least);
}

PixelDeviations pixel_deviations(const std::vector<BoardView>& views, const BundleState& state) {
  std::vector<double> camera, projector;
  const auto collect = [](const std::vector<Eigen::Vector2d>& residuals,
                          std::vector<double>& sizes) {
    for (const Eigen::Vector2d& residual : residuals) {
      if (!residual.allFinite()) continue;
      sizes.push_back(std::abs(residual.x()));
      sizes.push_back(std::abs(residual.y()));
    }
  };
  for (std::size_t v = 0; v < views.size(); ++v) {
    collect(camera_residuals(views[v], state.scanner, state.poses[v], state.places), camera);
    collect(projector_residuals(views[v], state.scanner, state.poses[v], state.places), projector);
  }
  return {robust_deviation(std::move(camera)), robust_deviation(std::move(projector))};
}

}  // namespace

BundleState bundle_adjusted(const std::vector<BoardView>& views, BundleState start,
                            const std::vector<Eigen::Vector3d>& printed,
                            const BundleSettings& settings, BundleDeviation* deviation) {
  const QuietCeres quiet;
  BundleState state = std::move(start);
  PixelDeviations deviations = pixel_deviations(views, state);
  for (int round = 0; round < settings.rounds; ++round) {
    BundleProblem problem(views, state, printed, settings, deviations);
    problem.solve();
    problem.parameters().write_to(state);
    deviations = pixel_deviations(views, state);
    if (round + 1 == settings.rounds && deviation != nullptr && !problem.estimate(*deviation)) {
      throw Error("the poses do not determine the calibration; tilt the board differently in each");
    }
  }
  return state;
}

std::vector<Eigen::Vector2d> camera_residuals(const BoardView& view, const Scanner& scanner,
                                              const Eigen::Isometry3d& pose,
                                              const std::vector<Eigen::Vector3d>& places) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d point = pose * places[static_cast<std::size_t>(view.places[i])];
    residuals.emplace_back(view.camera[i] - project(scanner.camera, point));
  }
  return residuals;
}

std::vector<Eigen::Vector2d> projector_residuals(const BoardView& view, const Scanner& scanner,
                                                 const Eigen::Isometry3d& pose,
                                                 const std::vector<Eigen::Vector3d>& places) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d point = pose * places[static_cast<std::size_t>(view.places[i])];
    residuals.emplace_back(view.projector[i] -
                           project(scanner.projector, in_projector_frame(scanner, point)));
  }
  return residuals;
}

}  // namespace slipstream
