#include "slipstream/calibrate/geometry_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/calibrate/coverage.h"
#include "slipstream/calibrate/first_guess.h"
#include "slipstream/calibrate/orientation.h"
#include "slipstream/calibrate/warnings.h"
#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/noise/robust.h"

namespace slipstream {
namespace {

/// Sum of squared distances, pixels^2, and how many there are.
struct SquaredDistances {
  double sum = 0;
  int count = 0;

  void add(const std::vector<Eigen::Vector2d>& residuals) {
    for (const Eigen::Vector2d& residual : residuals) {
      if (!residual.allFinite()) continue;
      sum += residual.squaredNorm();
      ++count;
    }
  }
  void add(const SquaredDistances& other) {
    sum += other.sum;
    count += other.count;
  }
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

struct DeviceDistances {
  SquaredDistances camera, projector;

  void add(const DeviceDistances& other) {
    camera.add(other.camera);
    projector.add(other.projector);
  }
  [[nodiscard]] ReprojectionRms rms() const {
    SquaredDistances both = camera;
    both.add(projector);
    return {camera.rms(), projector.rms(), both.rms()};
  }
};

DeviceDistances distances(const BoardView& view, const BundleState& state, std::size_t pose) {
  DeviceDistances result;
  result.camera.add(camera_residuals(view, state.scanner, state.poses[pose], state.places));
  result.projector.add(projector_residuals(view, state.scanner, state.poses[pose], state.places));
  return result;
}

template <class Item>
std::vector<Item> without(std::vector<Item> items, std::size_t left_out) {
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(left_out));
  return items;
}

/// RMS over both devices, of each pose.
std::vector<double> stereo_rms(const std::vector<BoardView>& views, const BundleState& state) {
  std::vector<double> rms;
  for (std::size_t v = 0; v < views.size(); ++v) {
    rms.push_back(distances(views[v], state, v).rms().stereo);
  }
  return rms;
}

/// A calibration of a simple model, of a board as printed: good enough to build on, and to see
/// whether the poses are of one rig.
BundleState simple_calibration(const std::vector<BoardView>& views,
                               const std::vector<Eigen::Vector3d>& printed, Size camera,
                               Size projector) {
  return bundle_adjusted(views, first_guess(views, printed, camera, projector), printed,
                         {.camera_coefficients = 2, .projector_coefficients = 2});
}

/// RMS of a pose, pixels, that is a blunder and not an imperfect board.
double blunder(Size camera) {
  constexpr double share_of_width = 0.003;
  constexpr double least = 1.5;
  return std::max(least, share_of_width * camera.width);
}

/// The one pose without which the others agree; the pose count where there is none.
std::size_t odd_pose(const std::vector<BoardView>& views,
                     const std::vector<Eigen::Vector3d>& printed, Size camera, Size projector) {
  if (views.size() <= fewest_poses) return views.size();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::vector<BoardView> rest = without(views, v);
    const std::vector<double> rms =
        stereo_rms(rest, simple_calibration(rest, printed, camera, projector));
    if (*std::max_element(rms.begin(), rms.end()) < blunder(camera)) return v;
  }
  return views.size();
}

/// Throws Error where a pose does not fit the others, or none fits any.
void require_one_rig(const std::vector<BoardView>& views, const BundleState& state,
                     const std::vector<Eigen::Vector3d>& printed) {
  constexpr double most_of_median = 8;
  const Size camera = state.scanner.camera.size, projector = state.scanner.projector.size;
  const std::vector<double> rms = stereo_rms(views, state);
  const auto worst = std::max_element(rms.begin(), rms.end());
  const double limit = std::max(1.5, std::min(blunder(camera), most_of_median * median(rms)));
  if (*worst < limit) return;
  const std::size_t odd = median(rms) < blunder(camera)
                              ? static_cast<std::size_t>(worst - rms.begin())
                              : odd_pose(views, printed, camera, projector);
  if (odd < views.size()) {
    throw Error(fmt::format(
        "{}: its corners do not fit the other poses (RMS {:.3g} px): another camera's frames, or "
        "the rig or the board moved; mend it or leave it out with --exclude",
        views[odd].name, rms[odd]));
  }
  throw Error(fmt::format(
      "the poses do not fit one camera and projector (median RMS {:.3g} px): frames of two "
      "cameras are mixed, the rig was moved, or the board or the patterns are not as said",
      median(rms)));
}

/// The board of each pose, measured with a calibration of the other poses.
std::vector<std::optional<BoardQuality>> left_out_qualities(
    const std::vector<BoardView>& views, const BundleState& state,
    const std::vector<Eigen::Vector3d>& printed, BundleSettings settings) {
  settings.pixel_deviations = pixel_deviations(views, state);
  std::vector<std::optional<BoardQuality>> qualities(views.size());
  for_each_row(static_cast<int>(views.size()), [&](int pose) {
    const auto v = static_cast<std::size_t>(pose);
    BundleState rest = state;
    rest.poses = without(state.poses, v);
    rest = bundle_adjusted(without(views, v), std::move(rest), printed, settings);
    qualities[v] = board_quality(views[v], rest.scanner, printed);
  });
  return qualities;
}

double largest_angle(const std::vector<Eigen::Isometry3d>& poses) {
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double cosine = poses[i].linear().col(2).dot(poses[j].linear().col(2));
      largest = std::max(largest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
  }
  return largest;
}

LensChoice chosen(const std::optional<int>& asked, const std::vector<BoardView>& views,
                  const BundleState& state, Device device) {
  if (asked) return {*asked, {}};
  return choose_lens_model(views, state, device);
}

void require_known_model(const std::optional<int>& coefficients, const char* device) {
  if (!coefficients ||
      std::find(lens_models.begin(), lens_models.end(), *coefficients) != lens_models.end()) {
    return;
  }
  throw Error(fmt::format("{} distortion coefficients for the {}; it is one of {}", *coefficients,
                          device, fmt::join(lens_models, ", ")));
}

}  // namespace

GeometryCalibration calibrate_geometry(std::vector<BoardView> views, const CalibrationBoard& board,
                                       Size camera, Size projector,
                                       const GeometryCalibrationSettings& settings) {
  require_valid(board);
  require_known_model(settings.camera_coefficients, "camera");
  require_known_model(settings.projector_coefficients, "projector");
  if (views.size() < fewest_poses) {
    throw Error(fmt::format("{} usable poses; at least {} are needed, ten are good", views.size(),
                            fewest_poses));
  }
  const std::vector<Eigen::Vector3d> printed = printed_places(board);
  for (BoardView& view : views) view = without_wrong_fringes(std::move(view), printed);
  for (const BoardView& view : views) require_same_handedness(view);

  GeometryCalibration result;
  BundleState& state = result.state;
  state = simple_calibration(views, printed, camera, projector);
  require_one_rig(views, state, printed);

  BundleSettings bundle;
  if (settings.print_deviation) bundle.print_deviation = *settings.print_deviation * board.spacing;
  state = bundle_adjusted(views, std::move(state), printed, bundle);
  result.camera_lens = chosen(settings.camera_coefficients, views, state, Device::camera);
  result.projector_lens = chosen(settings.projector_coefficients, views, state, Device::projector);

  bundle.camera_coefficients = result.camera_lens.coefficients;
  bundle.projector_coefficients = result.projector_lens.coefficients;
  forget_held_coefficients(state.scanner, bundle);
  state = bundle_adjusted(views, std::move(state), printed, bundle, &result.deviation);
  require_valid(state.scanner);

  const auto left_out = left_out_qualities(views, state, printed, bundle);
  DeviceDistances all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const DeviceDistances of_pose = distances(views[v], state, v);
    all.add(of_pose);
    result.poses.push_back({views[v].name, static_cast<int>(views[v].places.size()),
                            lit_corners(views[v]), of_pose.rms(), left_out[v]});
  }
  result.rms = all.rms();
  result.covered_camera = covered_share(coverage_map(views, Device::camera, camera));
  result.covered_projector = covered_share(coverage_map(views, Device::projector, projector));
  result.largest_tilt = largest_angle(state.poses);
  result.warnings = warnings_about(result);
  result.views = std::move(views);
  return result;
}

}  // namespace slipstream
