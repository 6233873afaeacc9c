#include "slipstream/calibrate/geometry_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/calibrate/coverage.h"
#include "slipstream/calibrate/diagnosis.h"
#include "slipstream/calibrate/first_guess.h"
#include "slipstream/calibrate/orientation.h"

namespace slipstream {
namespace {

template <class Item>
std::vector<Item> without(std::vector<Item> items, std::size_t left_out) {
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(left_out));
  return items;
}

/// What a calibration of the other poses makes of one.
struct LeftOut {
  Scanner scanner;  ///< of the others
  std::optional<BoardQuality> quality;
  ProjectorOffset offset;
  double misfit = 1;  ///< CalibratedPose::misfit
};

std::vector<LeftOut> each_left_out(const std::vector<BoardView>& views, const BundleState& state,
                                   const std::vector<Eigen::Vector3d>& printed,
                                   BundleSettings settings) {
  settings.pixel_deviations = pixel_deviations(views, state);
  const auto count = static_cast<double>(views.size());
  const double all = count * mean_squared_error(views, state, *settings.pixel_deviations);
  std::vector<LeftOut> left_out(views.size());
  for_each_row(static_cast<int>(views.size()), [&](int pose) {
    const auto v = static_cast<std::size_t>(pose);
    BundleState rest = state;
    rest.poses = without(state.poses, v);
    const std::vector<BoardView> others = without(views, v);
    rest = bundle_adjusted(others, std::move(rest), printed, settings);
    const double of_others = mean_squared_error(others, rest, *settings.pixel_deviations);
    left_out[v] = {rest.scanner, board_quality(views[v], rest.scanner, printed),
                   projector_offset(views[v], rest.scanner, state.poses[v], rest.places),
                   all / of_others - (count - 1)};
  });
  return left_out;
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

/// The board's corners as they would be estimated were they free.
PrintShape estimated_print(const std::vector<BoardView>& views, const BundleState& state,
                           const std::vector<Eigen::Vector3d>& printed, BundleSettings settings,
                           double usual_deviation) {
  if (settings.print_deviation) return print_shape(state.places, printed);
  settings.print_deviation = usual_deviation;
  return print_shape(bundle_adjusted(views, state, printed, settings).places, printed);
}

/// From the nearest to the farthest corner of all boards.
DepthRange depths_of(const std::vector<BoardView>& views, const BundleState& state) {
  DepthRange range{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const int place : views[v].places) {
      const double depth = (state.poses[v] * state.places[static_cast<std::size_t>(place)]).z();
      range = {std::min(range.nearest, depth), std::max(range.farthest, depth)};
    }
  }
  return range;
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
  state.scanner.calibrated_depths = depths_of(views, state);
  require_valid(state.scanner);

  const std::vector<LeftOut> left_out = each_left_out(views, state, printed, bundle);
  std::vector<Scanner> without_one;
  for (const LeftOut& of_pose : left_out) without_one.push_back(of_pose.scanner);
  result.deviation = widened(result.deviation, without_one);
  Reprojection all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Reprojection of_pose = reprojection(views[v], state, v);
    all.add(of_pose);
    result.poses.push_back({views[v].name, static_cast<int>(views[v].places.size()),
                            lit_corners(views[v]), of_pose.rms(), left_out[v].quality,
                            left_out[v].offset, left_out[v].misfit});
  }
  result.rms = all.rms();
  result.covered_camera = covered_share(coverage_map(views, Device::camera, camera));
  result.covered_projector = covered_share(coverage_map(views, Device::projector, projector));
  result.largest_tilt = largest_angle(state.poses);
  result.moved = moved_rig(views, state);
  const double usual_print_deviation =
      *GeometryCalibrationSettings{}.print_deviation * board.spacing;
  result.print = estimated_print(views, state, printed, bundle, usual_print_deviation);
  result.views = std::move(views);
  result.findings = findings_about(result);
  return result;
}

}  // namespace slipstream
