#include "scan_job/fused_cameras.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "base/throw_if-inl.h"
#include "reconstruct/camera_pair.h"
#include "reconstruct/coordinate_map.h"
#include "reconstruct/phase_matcher.h"
#include "reconstruct/points.h"
#include "scan_job/scan_colours.h"

namespace slipstream {
namespace {

/// From the camera's frame to the projector's.
Eigen::Isometry3d rig_of(const Scanner& scanner) {
  return Eigen::Translation3d(scanner.translation) * Eigen::Isometry3d(scanner.rotation);
}

/// From the camera's frame to the first camera's.
Eigen::Isometry3d to_first(const Scanner& camera, const Scanner& first) {
  return rig_of(first).inverse() * rig_of(camera);
}

/// The points where a camera's rays meet the projector's light at its coordinates, and how noise
/// moves them. `match`: has the grey levels. Throws Error if the phases should be corrected first.
ScanResult points_as_measured(const Scan& scan, EngineSetup setup, Maps maps, const Cloud& match) {
  throw_if(setup.scanner.photometry.response.has_value(),
           "points of a single frequency are fused as measured, not corrected for the response; "
           "match the cameras instead, use patterns that give the fringe order, or set `gamma "
           "none` if the response is nearly linear");

  ScanResult camera;
  camera.setup = std::move(setup);
  camera.maps = std::move(maps);
  camera.cloud = cloud_of_coordinates(converted<double>(camera.maps.coordinate), camera.setup);
  camera.cloud.intensity = match.intensity;
  camera.cloud.colour = colours_of(camera.cloud, scan);
  camera.uncertainty =
      uncertainty_of(camera.cloud, camera.maps, camera.setup, scan.frames.views().full_scale());
  return camera;
}

}  // namespace

std::vector<Scan> scans_of_cameras(Scan scan) {
  std::vector<Scan> further = std::exchange(scan.further_cameras, {});
  std::vector<Scan> scans;
  scans.push_back(std::move(scan));
  std::ranges::move(further, std::back_inserter(scans));
  return scans;
}

ReconstructSettings settings_for(const Scanner& camera, const Scanner& first,
                                 ReconstructSettings settings) {
  CleanSettings& clean = settings.clean;
  clean.outline.clear();
  if (!clean.box) return settings;

  FramePose frame{.from = std::string(camera_frame), .to = std::string(camera_frame)};
  if (clean.box_frame) frame = pose_from_frame(*clean.box_frame, camera_frame);
  frame.transform = frame.transform * to_first(camera, first);
  clean.box_frame = std::make_shared<const FramePose>(std::move(frame));
  return settings;
}

std::vector<ScanResult> points_by_each_other(const CheckedJob& job, const ScanResult& matched) {
  const Scan &first = job.scan, &second = first.further_cameras.front();
  std::vector<ScanResult> cameras;

  // 1. The match has the first camera's coordinates, in the orders that the second confirms.
  cameras.push_back(
      points_as_measured(first, setup_for(first, job.setup.settings), matched.maps, matched.cloud));

  // 2. The match back has the second camera's.
  EngineSetup setup = setup_for(second, job.setup.settings);
  setup.settings = settings_for(setup.scanner, job.setup.scanner, setup.settings);
  PhaseMatcher match_back(setup.scanner, setup_for(first).scanner, setup.sequence, setup.settings,
                          {.window = 0});
  const PhaseMatcher::Result back = match_back(second, first);
  cameras.push_back(points_as_measured(second, std::move(setup), back.maps, back.cloud));

  return cameras;
}

FusedModel fused_cameras(std::span<const ScanResult> cameras,
                         const std::shared_ptr<const FramePose>& frame) {
  constexpr std::size_t fewest = 100;  // points of a view

  const Scanner& first = cameras.front().setup.scanner;
  std::vector<View> views;
  std::vector<std::optional<Eigen::Isometry3d>> poses;

  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Cloud& cloud = cameras[i].cloud;
    const std::optional<Uncertainty>& uncertainty = cameras[i].uncertainty;
    const std::size_t points = count_by_validity(cloud).front();
    throw_if(points < fewest, "camera {} measures only {} points; {} or more of each are needed",
             i + 1, points, fewest);
    views.push_back(view_of(cloud, uncertainty ? &*uncertainty : nullptr, {},
                            cloud.colour.empty() ? nullptr : &cloud.colour));

    const Scanner& scanner = cameras[i].setup.scanner;
    if (i > 0) require_pair(first, scanner, {});
    const Eigen::Isometry3d pose = to_first(scanner, first);
    poses.emplace_back(frame ? frame->transform * pose : pose);
  }

  std::vector<const View*> sources;
  for (const View& view : views) sources.push_back(&view);
  FusedModel model = fuse(sources, poses);
  model.frame = frame;
  return model;
}

}  // namespace slipstream
