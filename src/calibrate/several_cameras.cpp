#include "calibrate/several_cameras.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "calibrate/bundle_adjustment.h"
#include "calibrate/cameras_adjustment.h"
#include "calibrate/left_out.h"
#include "calibrate/reprojection.h"

namespace slipstream {
namespace {

using Motion6 = Eigen::Matrix<double, 6, 1>;

/// Throws Error for residual maps, which the joint adjustment does not know.
void require_no_residual_maps(const std::vector<GeometryCalibration>& alone,
                              const GeometryCalibrationSettings& settings) {
  const bool has_map = std::ranges::any_of(alone, [](const GeometryCalibration& camera) {
    const Scanner& scanner = camera.state.scanner;
    return !scanner.camera.residual.terms.empty() || !scanner.projector.residual.terms.empty();
  });

  throw_if(settings.residual || has_map,
           "residual maps are not supported for several cameras; set `residual` to false");
}

/// Numbers the poses by their names.
CamerasViews joint_views(const std::vector<GeometryCalibration>& alone) {
  CamerasViews views;
  std::map<std::string, std::size_t> numbers;
  for (const GeometryCalibration& camera : alone) {
    std::vector<std::size_t> poses;
    std::size_t shared = 0;
    for (const BoardView& view : camera.views) {
      const auto [found, is_new] = numbers.emplace(view.name, numbers.size());
      poses.push_back(found->second);
      shared += is_new ? 0 : 1;
    }

    throw_if(!views.cameras.empty() && shared < fewest_poses,
             "camera {} shares {} poses with those before; at least {} must be the same board held "
             "still, with the same name",
             views.cameras.size() + 1, shared, fewest_poses);
    views.cameras.push_back(camera.views);
    views.poses.push_back(std::move(poses));
  }
  return views;
}

CamerasState joint_start(const std::vector<GeometryCalibration>& alone, const CamerasViews& views) {
  const BundleState& first = alone.front().state;
  CamerasState state{.cameras = {},
                     .projector = first.scanner.projector,
                     .rig = rig_of(first.scanner),
                     .cameras_from_first = {},
                     .poses = {},
                     .places = first.places};

  std::map<std::size_t, Eigen::Isometry3d> poses;
  for (std::size_t c = 0; c < alone.size(); ++c) {
    const BundleState& own = alone[c].state;
    throw_if(own.scanner.projector.size != state.projector.size,
             "the cameras' scans were taken with projectors of different sizes");

    state.cameras.push_back(own.scanner.camera);
    state.cameras_from_first.push_back(rig_of(own.scanner).inverse() * state.rig);
    for (std::size_t v = 0; v < own.poses.size(); ++v) {
      poses.emplace(views.poses[c][v], state.cameras_from_first[c].inverse() * own.poses[v]);
    }
  }

  for (const auto& [number, pose] : poses) state.poses.push_back(pose);
  return state;
}

/// The views without those of a pose. The pose stays, without any view.
CamerasViews without_pose(const CamerasViews& views, std::size_t pose) {
  CamerasViews rest{std::vector<BoardViews>(views.cameras.size()),
                    std::vector<std::vector<std::size_t>>(views.cameras.size())};
  for (std::size_t c = 0; c < views.cameras.size(); ++c) {
    for (std::size_t v = 0; v < views.cameras[c].size(); ++v) {
      if (views.poses[c][v] == pose) continue;
      rest.cameras[c].push_back(views.cameras[c][v]);
      rest.poses[c].push_back(views.poses[c][v]);
    }
  }
  return rest;
}

CamerasSettings joint_settings(const std::vector<GeometryCalibration>& alone, double spacing,
                               const GeometryCalibrationSettings& settings) {
  CamerasSettings joint;
  joint.projector_coefficients = 0;
  for (const GeometryCalibration& camera : alone) {
    joint.camera_coefficients.push_back(camera.camera_lens.coefficients);
    joint.projector_coefficients =
        std::max(joint.projector_coefficients, camera.projector_lens.coefficients);
  }
  if (settings.print_deviation) joint.print_deviation = *settings.print_deviation * spacing;
  return joint;
}

/// Turn and shift of a motion relative to another.
Motion6 motion_from(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::AngleAxisd turn(to.linear() * from.linear().transpose());
  Motion6 motion;
  motion << turn.angle() * turn.axis(), to.translation() - from.translation();
  return motion;
}

/// The poses of the cameras after the first, with the larger of both deviations: see widened.
std::vector<CameraPose> camera_poses(const CamerasState& state, const CamerasDeviation& deviation,
                                     const std::vector<CamerasState>& without_one) {
  std::vector<CameraPose> poses;
  for (std::size_t c = 1; c < state.cameras.size(); ++c) {
    const Eigen::Isometry3d& pose = state.cameras_from_first[c];

    std::vector<Motion6> changes;
    for (const CamerasState& rest : without_one) {
      changes.push_back(motion_from(pose, rest.cameras_from_first[c]));
    }

    const Motion6 sigma = jackknife(changes).cwiseMax(deviation.motions[c]);
    poses.push_back({pose, sigma.head<3>(), sigma.tail<3>()});
  }
  return poses;
}

/// Puts the joint result into a camera's calibration. Throws Error if its scanner is not valid.
void update(GeometryCalibration& camera, const BundleState& state,
            const BundleDeviation& deviation) {
  const Scanner before = camera.state.scanner;
  camera.state = state;
  camera.state.scanner.photometry = before.photometry;
  camera.state.scanner.calibrated_depths = before.calibrated_depths;
  camera.deviation = deviation;

  for (std::size_t v = 0; v < camera.views.size(); ++v) {
    camera.poses[v].rms = reprojection(camera.views[v], camera.state, v).rms();
  }
  camera.rms = reprojection(camera.views, camera.state).rms();
  camera.state.scanner.calibration_rms = camera.rms.stereo;
  require_valid(camera.state.scanner);
}

}  // namespace

CamerasCalibration calibrate_together(std::vector<GeometryCalibration> alone,
                                      const BoardPlaces& printed, double spacing,
                                      const GeometryCalibrationSettings& settings) {
  throw_if(alone.size() < 2, "several cameras are calibrated together; there is only one");
  require_no_residual_maps(alone, settings);

  // 1. All cameras at once, from where each is alone.
  const CamerasViews views = joint_views(alone);
  CamerasSettings joint = joint_settings(alone, spacing, settings);
  CamerasDeviation deviation;
  const CamerasState state =
      jointly_adjusted(views, joint_start(alone, views), printed, joint, &deviation);

  // 2. The same without each pose, for the standard deviations and the qualities.
  for (std::size_t c = 0; c < alone.size(); ++c) {
    joint.pixel_deviations.push_back(
        pixel_deviations(views.cameras[c], state_of_camera(state, views, c)));
  }
  std::vector<CamerasState> without_one(state.poses.size());
  for_each_row(static_cast<int>(state.poses.size()), [&](int pose) {
    without_one[pose] = jointly_adjusted(without_pose(views, pose), state, printed, joint);
  });

  // 3. Each camera by itself.
  CamerasCalibration result{std::move(alone), camera_poses(state, deviation, without_one)};
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    GeometryCalibration& camera = result.cameras[c];

    std::vector<Scanner> scanners;
    for (const CamerasState& rest : without_one) {
      scanners.push_back(state_of_camera(rest, views, c).scanner);
    }
    update(camera, state_of_camera(state, views, c),
           widened(deviation_of_camera(deviation, c), scanners));
    camera.projector_lens.coefficients = joint.projector_coefficients;

    for (std::size_t v = 0; v < camera.views.size(); ++v) {
      camera.poses[v].left_out =
          board_quality(camera.views[v], scanners[views.poses[c][v]], printed);
    }
  }
  return result;
}

}  // namespace slipstream
