#include "slipstream/calibrate/geometry_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>
#include <Eigen/QR>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/calibrate/diagnosis.h"
#include "slipstream/calibrate/first_guess.h"

namespace slipstream {
namespace {

/// Least squares of A x = b: x and its standard deviations by what is left.
struct Fitted {
  Eigen::VectorXd values, deviations;
};

Fitted fitted(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Fitted fit{A.colPivHouseholderQr().solve(b), {}};
  const double variance = (A * fit.values - b).squaredNorm() /
                          static_cast<double>(std::max<Eigen::Index>(1, A.rows() - A.cols()));
  fit.deviations = ((A.transpose() * A).inverse().diagonal() * variance).cwiseSqrt();
  return fit;
}

/// By the corners as a calibration estimated them, mm, in the frame of the `printed` ones.
PrintShape print_shape(const std::vector<Eigen::Vector3d>& places,
                       const std::vector<Eigen::Vector3d>& printed) {
  const auto count = static_cast<Eigen::Index>(printed.size());
  const Eigen::Map<const Eigen::Matrix3Xd> is(places.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> ought(printed.front().data(), 3, count);
  const Eigen::Vector3d least = ought.rowwise().minCoeff(), most = ought.rowwise().maxCoeff();
  const Eigen::ArrayXd u = (2 * ought.row(0).array() - most.x() - least.x()) / (most - least).x();
  const Eigen::ArrayXd v = (2 * ought.row(1).array() - most.y() - least.y()) / (most - least).y();
  Eigen::MatrixXd terms(count, 6);
  terms << Eigen::VectorXd::Ones(count), u, v, u * u, u * v, v * v;

  PrintShape shape{.size = (most - least).norm()};
  const Fitted heights = fitted(terms, is.row(2).transpose());
  for (const Eigen::Index term : {3, 4, 5}) {
    if (std::abs(heights.values[term]) < shape.bend) continue;
    shape.bend = std::abs(heights.values[term]);
    shape.bend_deviation = heights.deviations[term];
  }
  const Fitted across = fitted(terms.leftCols<3>(), is.row(0).transpose());
  const Fitted down = fitted(terms.leftCols<3>(), is.row(1).transpose());
  const double wide = (most - least).x() / 2, high = (most - least).y() / 2;
  shape.stretch = down.values[2] / high / (across.values[1] / wide) - 1;
  shape.stretch_deviation = std::hypot(down.deviations[2] / high, across.deviations[1] / wide);
  return shape;
}

/// What a calibration of the other poses makes of each one, in `poses`; returns the scanners of
/// these calibrations.
std::vector<Scanner> leave_each_out(const std::vector<BoardView>& views, const BundleState& state,
                                    const std::vector<Eigen::Vector3d>& printed,
                                    BundleSettings settings, std::vector<CalibratedPose>& poses) {
  settings.pixel_deviations = pixel_deviations(views, state);
  const auto count = static_cast<double>(views.size());
  const double all = count * mean_squared_error(views, state, *settings.pixel_deviations);
  std::vector<Scanner> scanners(views.size());
  for_each_row(static_cast<int>(views.size()), [&](int pose) {
    const auto v = static_cast<std::size_t>(pose);
    SomePoses others = some_poses(views, state, [&](std::size_t i) { return i != v; });
    const BundleState rest =
        bundle_adjusted(others.views, std::move(others.state), printed, settings);
    const double of_others = mean_squared_error(others.views, rest, *settings.pixel_deviations);
    poses[v].left_out = board_quality(views[v], rest.scanner, printed);
    poses[v].offset = projector_offset(views[v], rest.scanner, state.poses[v], rest.places);
    poses[v].misfit = all / of_others - (count - 1);
    scanners[v] = rest.scanner;
  });
  return scanners;
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
  views = checked_views(std::move(views), printed);

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

  Reprojection all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Reprojection of_pose = reprojection(views[v], state, v);
    all.add(of_pose);
    result.poses.push_back({.name = views[v].name,
                            .corners = static_cast<int>(views[v].places.size()),
                            .lit = lit_corners(views[v]),
                            .rms = of_pose.rms()});
  }
  result.rms = all.rms();
  result.deviation =
      widened(result.deviation, leave_each_out(views, state, printed, bundle, result.poses));
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
