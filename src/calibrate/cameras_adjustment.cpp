#include "calibrate/cameras_adjustment.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "base/throw_if-inl.h"
#include "calibrate/adjustment.h"
#include "calibrate/board_view.h"
#include "calibrate/corner_errors.h"
#include "calibrate/quiet_ceres.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

PoseNumbers motion_numbers(const Eigen::Isometry3d& motion) {
  return numbers_of(motion.linear(), motion.translation());
}

/// The parameters of a CamerasState, as Ceres adjusts them.
struct CamerasNumbers {
  explicit CamerasNumbers(const CamerasState& state)
      : projector(numbers_of(state.projector)),
        rig(motion_numbers(state.rig)),
        places(state.places) {
    for (const Lens& lens : state.cameras) cameras.push_back(numbers_of(lens));
    for (const auto& motion : state.cameras_from_first) motions.push_back(motion_numbers(motion));
    for (const Eigen::Isometry3d& pose : state.poses) poses.push_back(motion_numbers(pose));
  }

  void write_to(CamerasState& state) const {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      set_lens(state.cameras[c], cameras[c]);
      state.cameras_from_first[c] = pose_of(motions[c]);
    }
    set_lens(state.projector, projector);
    state.rig = pose_of(rig);
    for (std::size_t i = 0; i < poses.size(); ++i) state.poses[i] = pose_of(poses[i]);
    state.places = places;
  }

  std::vector<LensNumbers> cameras;
  LensNumbers projector;
  PoseNumbers rig;
  std::vector<PoseNumbers> motions, poses;
  BoardPlaces places;
};

LensDeviation lens_deviation(const Eigen::VectorXd& numbers) {
  LensDeviation deviation{.focal = numbers.head<2>(), .principal_point = numbers.segment<2>(2)};
  std::copy_n(numbers.data() + 4, deviation.coefficients.size(), deviation.coefficients.begin());
  return deviation;
}

class CamerasProblem {
 public:
  CamerasProblem(const CamerasViews& views, const CamerasState& state, const BoardPlaces& printed,
                 const CamerasSettings& settings, const std::vector<PixelDeviations>& deviations)
      : numbers_(state) {
    for (std::size_t c = 0; c < views.cameras.size(); ++c) {
      for (std::size_t v = 0; v < views.cameras[c].size(); ++v) {
        add_view(views.cameras[c][v], c, views.poses[c][v], deviations[c]);
      }
      adjustment_.settle_lens(numbers_.cameras[c], settings.hold_cameras,
                              settings.camera_coefficients[c]);
    }

    adjustment_.settle_lens(numbers_.projector, settings.hold_projector,
                            settings.projector_coefficients);

    adjustment_.hold(numbers_.motions[0].data());  // the first camera is the base
    if (settings.hold_rig) adjustment_.hold(numbers_.rig.data());
    adjustment_.settle_places(numbers_.places, printed, settings.print_deviation);
  }

  void solve(double tolerance) { adjustment_.solve(tolerance); }

  [[nodiscard]] const CamerasNumbers& numbers() const { return numbers_; }

  /// Returns false if the data do not determine the parameters.
  bool estimate(CamerasDeviation& deviation) {
    std::vector<std::pair<double*, int>> blocks{{numbers_.projector.data(), lens_number_count},
                                                {numbers_.rig.data(), 6}};
    for (std::size_t c = 0; c < numbers_.cameras.size(); ++c) {
      blocks.emplace_back(numbers_.cameras[c].data(), lens_number_count);
      if (c > 0) blocks.emplace_back(numbers_.motions[c].data(), 6);
    }

    const auto all = adjustment_.deviations_of(blocks);
    if (!all) return false;

    Eigen::Index at = 0;
    for (const auto& [block, length] : blocks) {
      const Eigen::VectorXd part = all->segment(at, length);
      if (length == 6) deviation.motions.emplace_back(part);
      if (length != 6 && at == 0) deviation.projector = lens_deviation(part);
      if (length != 6 && at > 0) deviation.cameras.push_back(lens_deviation(part));
      at += length;
    }
    return true;
  }

 private:
  void add_view(const BoardView& view, std::size_t c, std::size_t p,
                const PixelDeviations& deviations) {
    double* const camera = numbers_.cameras[c].data();
    double* const projector = numbers_.projector.data();
    double* const rig = numbers_.rig.data();
    double* const motion = numbers_.motions[c].data();
    double* const pose = numbers_.poses[p].data();

    for (std::size_t i = 0; i < view.places.size(); ++i) {
      double* const place = numbers_.places[view.places[i]].data();
      const Eigen::Vector2d &seen = view.camera[i], &lit = view.projector[i];

      // A corner that one device sees still determines the pose and that device's lens.
      if (is_lit(view, i)) {
        adjustment_.add(std::make_unique<PairError>(seen, lit, slope_at(view, i), deviations), true,
                        camera, projector, motion, rig, pose, place);
      } else if (seen.allFinite()) {
        adjustment_.add(std::make_unique<CornerError>(seen, deviations.camera), true, camera,
                        motion, pose, place);
      } else if (lit.allFinite()) {
        adjustment_.add(std::make_unique<CornerError>(lit, deviations.projector), true, projector,
                        rig, pose, place);
      }
    }
  }

  CamerasNumbers numbers_;
  Adjustment adjustment_;
};

std::vector<PixelDeviations> deviations_by_camera(const CamerasViews& views,
                                                  const CamerasState& state) {
  std::vector<PixelDeviations> all;
  for (std::size_t c = 0; c < views.cameras.size(); ++c) {
    all.push_back(pixel_deviations(views.cameras[c], state_of_camera(state, views, c)));
  }
  return all;
}

}  // namespace

Eigen::Isometry3d rig_of(const Scanner& scanner) {
  return pose_from(scanner.rotation, scanner.translation);
}

BundleState state_of_camera(const CamerasState& state, const CamerasViews& views,
                            std::size_t camera) {
  const Eigen::Isometry3d& from_first = state.cameras_from_first[camera];
  const Eigen::Isometry3d rig = state.rig * from_first.inverse();

  BundleState own{
      {state.cameras[camera], state.projector, rig.linear(), rig.translation()}, {}, state.places};
  for (const std::size_t pose : views.poses[camera]) {
    own.poses.push_back(from_first * state.poses[pose]);
  }
  return own;
}

BundleDeviation deviation_of_camera(const CamerasDeviation& deviation, std::size_t camera) {
  BundleDeviation own{.camera = deviation.cameras[camera], .projector = deviation.projector};
  if (camera == 0) {
    own.rotation = deviation.motions[0].head<3>();
    own.translation = deviation.motions[0].tail<3>();
  }
  return own;
}

CamerasState jointly_adjusted(const CamerasViews& views, CamerasState start,
                              const BoardPlaces& printed, const CamerasSettings& settings,
                              CamerasDeviation* deviation) {
  const QuietCeres quiet;
  const bool known = !settings.pixel_deviations.empty();
  const int rounds = known ? 1 : 3;

  CamerasState state = std::move(start);
  std::vector<PixelDeviations> deviations =
      known ? settings.pixel_deviations : deviations_by_camera(views, state);

  for (int round = 0; round < rounds; ++round) {
    CamerasProblem problem(views, state, printed, settings, deviations);
    problem.solve(known ? 1e-7 : 1e-9);  // refinement or first solution
    problem.numbers().write_to(state);
    deviations = deviations_by_camera(views, state);

    const bool estimates = round + 1 == rounds && deviation != nullptr;
    throw_if(estimates && !problem.estimate(*deviation),
             "the poses do not determine the calibration{}; likely too few tilts of the board: "
             "tilt it differently in each",
             state.cameras.size() > 1 ? " of all cameras" : "");
  }
  return state;
}

}  // namespace slipstream
