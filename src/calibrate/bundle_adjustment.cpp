#include "calibrate/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/throw_if-inl.h"
#include "calibrate/adjustment.h"
#include "calibrate/board_view.h"
#include "calibrate/corner_errors.h"
#include "calibrate/quiet_ceres.h"
#include "calibrate/reprojection.h"

namespace slipstream {
namespace {

/// Camera, projector and their relative pose, concatenated.
using RigNumbers = Eigen::Matrix<double, 2 * lens_number_count + 6, 1>;

RigNumbers rig_numbers_of(const Scanner& scanner) {
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
  PoseNumbers base{};  ///< the camera's own motion: none
  PoseNumbers rig;
  std::vector<PoseNumbers> poses;
  BoardPlaces places;
};

class BundleProblem {
 public:
  BundleProblem(const BoardViews& views, const BundleState& state, const BoardPlaces& printed,
                const BundleSettings& settings, const PixelDeviations& deviations)
      : parameters_(state) {
    for (std::size_t v = 0; v < views.size(); ++v) add_view(views[v], v, deviations);
    adjustment_.settle_lens(parameters_.camera, settings.hold_camera, settings.camera_coefficients);
    adjustment_.settle_lens(parameters_.projector, settings.hold_projector,
                            settings.projector_coefficients);

    adjustment_.hold(parameters_.base.data());
    if (settings.hold_rig) adjustment_.hold(parameters_.rig.data());
    adjustment_.settle_places(parameters_.places, printed, settings.print_deviation);
  }

  void solve(double tolerance) { adjustment_.solve(tolerance); }

  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

  /// Returns false if the data do not determine the parameters.
  bool estimate(BundleDeviation& deviation) {
    // In the order of RigNumbers.
    const auto deviations =
        adjustment_.deviations_of({{parameters_.camera.data(), lens_number_count},
                                   {parameters_.projector.data(), lens_number_count},
                                   {parameters_.rig.data(), 6}});
    if (!deviations) return false;

    with_row(deviation, *deviations, [](double& value, double number) { value = number; });
    return true;
  }

 private:
  void add_view(const BoardView& view, std::size_t v, const PixelDeviations& deviations) {
    double* const camera = parameters_.camera.data();
    double* const projector = parameters_.projector.data();
    double* const base = parameters_.base.data();
    double* const rig = parameters_.rig.data();
    double* const pose = parameters_.poses[v].data();

    for (std::size_t i = 0; i < view.places.size(); ++i) {
      double* const place = parameters_.places[view.places[i]].data();

      // A corner that one device sees still determines the pose and that device's lens.
      if (is_lit(view, i)) {
        adjustment_.add(std::make_unique<PairError>(view.camera[i], view.projector[i],
                                                    slope_at(view, i), deviations),
                        true, camera, projector, base, rig, pose, place);
      } else if (view.camera[i].allFinite()) {
        adjustment_.add(std::make_unique<CornerError>(view.camera[i], deviations.camera), true,
                        camera, base, pose, place);
      } else if (view.projector[i].allFinite()) {
        adjustment_.add(std::make_unique<CornerError>(view.projector[i], deviations.projector),
                        true, projector, rig, pose, place);
      }
    }
  }

  Parameters parameters_;
  Adjustment adjustment_;
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

    throw_if(round + 1 == rounds && deviation != nullptr && !problem.estimate(*deviation),
             "the poses do not determine the calibration; likely too few tilts of the board: tilt "
             "it differently in each");
  }

  state.scanner.camera.residual = of_camera;
  state.scanner.projector.residual = of_projector;
  return state;
}

BundleDeviation widened(BundleDeviation deviation, const std::vector<Scanner>& without_one) {
  const auto m = static_cast<double>(without_one.size());

  RigNumbers mean = RigNumbers::Zero(), squares = RigNumbers::Zero();
  for (const Scanner& scanner : without_one) mean += rig_numbers_of(scanner) / m;
  for (const Scanner& scanner : without_one)
    squares += (rig_numbers_of(scanner) - mean).cwiseAbs2();

  const RigNumbers jackknife = ((m - 1) / m * squares).cwiseSqrt();
  with_row(deviation, jackknife,
           [](double& value, double number) { value = std::max(value, number); });
  return deviation;
}

}  // namespace slipstream
