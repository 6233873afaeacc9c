#include "calibrate/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "calibrate/adjustment.h"
#include "calibrate/cameras_adjustment.h"
#include "calibrate/left_out.h"

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

/// The views with corners where the lens models without their residual maps see them.
BoardViews without_residual(BoardViews views, const Scanner& scanner) {
  for (BoardView& view : views) {
    for (Eigen::Vector2d& pixel : view.camera) pixel -= shift_at(scanner.camera.residual, pixel);
    for (Eigen::Vector2d& pixel : view.projector) {
      pixel -= shift_at(scanner.projector.residual, pixel);
    }
  }
  return views;
}

}  // namespace

void forget_held_coefficients(Scanner& scanner, const BundleSettings& settings) {
  const auto forget = [](Lens& lens, int free) {
    auto& k = lens.distortion.coefficients;
    std::fill(k.begin() + free, k.end(), 0.0);
  };
  forget(scanner.camera, settings.camera_coefficients);
  forget(scanner.projector, settings.projector_coefficients);
}

BundleState bundle_adjusted(const BoardViews& seen, BundleState state, const BoardPlaces& printed,
                            const BundleSettings& settings, BundleDeviation* deviation) {
  // 1. The views of a single camera.
  Scanner& scanner = state.scanner;
  CamerasViews views;
  views.cameras.push_back(without_residual(seen, scanner));
  views.poses.emplace_back(seen.size());
  std::iota(views.poses[0].begin(), views.poses[0].end(), std::size_t{0});

  CamerasSettings joint{.camera_coefficients = {settings.camera_coefficients},
                        .projector_coefficients = settings.projector_coefficients,
                        .hold_cameras = settings.hold_camera,
                        .hold_projector = settings.hold_projector,
                        .hold_rig = settings.hold_rig,
                        .print_deviation = settings.print_deviation};
  if (settings.pixel_deviations) joint.pixel_deviations = {*settings.pixel_deviations};

  // 2. The adjusted lenses have no residual maps: the corners are shifted instead.
  const LensResidual of_camera = std::exchange(scanner.camera.residual, {});
  const LensResidual of_projector = std::exchange(scanner.projector.residual, {});

  CamerasDeviation deviations;
  const CamerasState adjusted =
      jointly_adjusted(views,
                       {.cameras = {scanner.camera},
                        .projector = scanner.projector,
                        .rig = rig_of(scanner),
                        .cameras_from_first = {Eigen::Isometry3d::Identity()},
                        .poses = state.poses,
                        .places = state.places},
                       printed, joint, deviation != nullptr ? &deviations : nullptr);
  if (deviation != nullptr) *deviation = deviation_of_camera(deviations, 0);

  // 3. Back into the scanner, which keeps its maps and all that is not adjusted.
  scanner.camera = adjusted.cameras[0];
  scanner.camera.residual = of_camera;
  scanner.projector = adjusted.projector;
  scanner.projector.residual = of_projector;
  scanner.rotation = adjusted.rig.linear();
  scanner.translation = adjusted.rig.translation();
  state.poses = adjusted.poses;
  state.places = adjusted.places;
  return state;
}

BundleDeviation widened(BundleDeviation deviation, const std::vector<Scanner>& without_one) {
  std::vector<RigNumbers> rows;
  for (const Scanner& scanner : without_one) rows.push_back(rig_numbers_of(scanner));

  with_row(deviation, jackknife(rows),
           [](double& value, double number) { value = std::max(value, number); });
  return deviation;
}

}  // namespace slipstream
