#include "scan_job/fused_cameras.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/throw_if-inl.h"
#include "merge/seen_surface.h"
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

/// Appends a camera's findings, from the given one on, which then name it.
void append(std::vector<Finding>& findings, const CheckedScan& camera, std::size_t number,
            std::size_t first = 0) {
  for (std::size_t i = first; i < camera.findings.size(); ++i) {
    std::string& subject = findings.emplace_back(camera.findings[i]).subject;
    subject = fmt::format("camera {}{}{}", number, subject.empty() ? "" : ", ", subject);

    // The setting `order` would reorder the first camera's frames, too.
    for (auto& [text, settings] : findings.back().remedies) {
      if (settings.empty() || settings.front().name != "order") continue;
      text =
          fmt::format("list its frames in its scan.yaml in the order {}",
                      settings.front().value.empty() ? "of the patterns" : settings.front().value);
      settings.clear();
    }
  }
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

/// The share of two cameras' points that the other camera sees as if they floated in front of the
/// surface. Points behind it may be hidden from that camera. 0 if too few are comparable.
double floating_share(const View& one, const View& other, const Eigen::Isometry3d& to_other) {
  constexpr std::size_t step = 4;  // every fourth point is enough
  constexpr double fewest = 25;

  double floating = 0, near = 0;
  const auto compare = [&](const View& from, const View& to, const Eigen::Isometry3f& pose) {
    const SeenSurface seen(to);
    for (std::size_t i = 0; i < from.size(); i += step) {
      const Sight sight = seen.at(pose * from.points[i], from.sigma[i]);
      floating += sight == Sight::clear ? 1 : 0;
      near += sight == Sight::near ? 1 : 0;
    }
  };
  compare(one, other, to_other.cast<float>());
  compare(other, one, to_other.inverse().cast<float>());

  if (floating + near < fewest) return 0;
  return floating / (floating + near);
}

/// Cameras whose points of one surface lie apart by more than noise explains.
std::optional<Finding> cameras_apart(const FusedModel& model, const std::vector<View>& views,
                                     const std::vector<std::optional<Eigen::Isometry3d>>& poses) {
  constexpr double most_floating = 0.25, hopeless = 0.5;
  constexpr double most_sigmas = 5;

  // 1. The two cameras that fit together worst.
  double worst = 0;
  std::string cameras;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = i + 1; k < views.size(); ++k) {
      const double share = floating_share(views[i], views[k], poses[k]->inverse() * *poses[i]);
      if (share < worst) continue;
      worst = share;
      cameras = fmt::format("{} and {}", i + 1, k + 1);
    }
  }

  // 2. How far apart the points are that were averaged.
  std::vector<double> sigmas;
  for (const View& view : views) std::ranges::copy(view.sigma, std::back_inserter(sigmas));
  const double sigma = median(std::move(sigmas));
  const double disagreement = quality_of(model).median_disagreement.value_or(0);
  if (worst <= most_floating && disagreement <= most_sigmas * sigma) return std::nullopt;

  return Finding{
      .kind = FindingKind::cameras_apart,
      .severity = worst > hopeless ? Severity::wrong : Severity::doubtful,
      .what = fmt::format("the points of cameras {} lie apart where both see a surface", cameras),
      .evidence = {{"share in front of the other camera's surface", worst, "", most_floating},
                   {"median disagreement", disagreement, "mm", most_sigmas * sigma},
                   {"median sigma of a point", sigma, "mm"}},
      .causes = {{CauseKind::rig_moved,
                  "the cameras' scanner files do not fit together: a camera moved since "
                  "calibration"},
                 {CauseKind::gamma, "a response that is not corrected"}}};
}

}  // namespace

CheckedJob checked_job(Scan scan, const ScanJobSettings& settings, const std::string& name) {
  // 1. Three or more cameras are always fused.
  const std::size_t further = scan.further_cameras.size();
  const bool fuses = settings.output == ScanOutput::points && scan.scanner &&
                     (further > 1 || (settings.fuse && further > 0));
  throw_if(settings.fuse && !fuses,
           "{}: `fuse` needs points of two or more cameras with calibrated projector", name);

  // 2. Each camera by itself if its frames give the fringe order.
  std::vector<Scan> scans;
  if (fuses && has_coordinate(scan.sequence.strategy)) {
    scans = scans_of_cameras(std::move(scan));
  } else {
    scans.push_back(std::move(scan));
  }

  CheckedJob job = checked_camera(std::move(scans.front()), settings, name);
  job.fuses = fuses;

  ScanJobSettings own = settings;
  own.photometry = {};  // the first camera's
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const std::string camera = fmt::format("{}, camera {}", name, i + 1);
    throw_if(!scans[i].scanner, "{}: its scanner is unknown; name its file with `second_scanner`",
             camera);
    own.reconstruct = settings_for(*scans[i].scanner, job.setup.scanner, settings.reconstruct);

    job.further.push_back(checked_camera(std::move(scans[i]), own, camera));
    job.further.back().fuses = true;
    const CheckedScan& checked = job.further.back().checked;
    append(job.checked.findings, checked, i + 1);
    std::ranges::copy(checked.repairs, std::back_inserter(job.checked.repairs));
  }
  return job;
}

void ScanJob::fuse_cameras(const CheckedJob& job, const std::string& name, ScanResult& result) {
  Stopwatch watch;

  // 1. The points of each camera.
  std::vector<ScanResult> cameras;
  if (job.further.empty()) {
    cameras = points_by_each_other(job, result);
  } else {
    cameras.push_back(result);
  }

  for (std::size_t i = 0; i < job.further.size(); ++i) {
    if (further_.size() == i) further_.emplace_back(settings_);
    const CheckedJob& further = job.further[i];
    cameras.push_back(further_[i].result_of(further, fmt::format("{}, camera {}", name, i + 2)));
    append(result.checked.findings, cameras.back().checked, i + 2, further.checked.findings.size());
    result.choosing += further.choosing;
    result.checking += further.checking;
  }

  // 2. All points as one cloud.
  for (const ScanResult& camera : cameras) {
    result.points_of_cameras.push_back(point_count(camera.cloud));
  }
  std::vector<Finding>& findings = result.checked.findings;
  const std::size_t known = findings.size();

  // Wrong frames and an uncorrected response move points apart, and are reported already.
  const bool is_explained =
      any_wrong(findings) || std::ranges::any_of(findings, [](const Finding& finding) {
        return blames(finding, CauseKind::gamma);
      });
  try {
    result.fused = std::make_shared<const FusedModel>(
        fused_cameras(cameras, is_explained ? nullptr : &findings));
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
  if (!settings_.keep_refused) require_right(result.checked, name, known);
  result.computing += watch.lap();
}

ModelPoints fused_points(const ScanResult& result) {
  throw_if(result.fused == nullptr, "the cameras of this scan were not fused");
  return model_points(*result.fused);
}

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

void require_matchable(const ReconstructSettings& settings) {
  throw_if(rejects_reflection(settings.clean),
           "`reflection` and `local_reflection` need one camera, or cameras that are fused and "
           "patterns of several frequencies");
  throw_if(settings.correct_contrast,
           "`correct_contrast` needs one camera, or cameras that are fused and patterns that give "
           "the fringe order");
}

FusedModel fused_cameras(std::span<const ScanResult> cameras, std::vector<Finding>* findings) {
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
    poses.emplace_back(to_first(scanner, first));
  }

  std::vector<const View*> sources;
  for (const View& view : views) sources.push_back(&view);
  FusedModel model = fuse(sources, poses);
  if (findings != nullptr) {
    if (auto apart = cameras_apart(model, views, poses)) findings->push_back(*std::move(apart));
  }
  return model;
}

}  // namespace slipstream
