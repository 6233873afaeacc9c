#include "slipstream/geometry_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Core>

#include "base/linear_algebra.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "calibrate/board_view.h"
#include "calibrate/bundle_adjustment.h"
#include "calibrate/diagnosis.h"
#include "calibrate/first_guess.h"
#include "calibrate/left_out.h"
#include "calibrate/one_rig.h"
#include "calibrate/reprojection.h"
#include "calibrate/residual_map.h"

namespace slipstream {
namespace {

/// Least squares of A x = b: x and its standard deviations from the residuals.
struct Fitted {
  Eigen::VectorXd values, deviations;
};

Fitted fitted(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Fitted fit{least_squares(A, b).X, {}};

  // Variance of the residuals; the inverse of A^T A gives each value's share of it.
  const double variance = (A * fit.values - b).squaredNorm() /
                          static_cast<double>(std::max<Eigen::Index>(1, A.rows() - A.cols()));
  fit.deviations = (inverse_of(A.transpose() * A).diagonal() * variance).cwiseSqrt();
  return fit;
}

/// `places`: estimated corners, mm, in the frame of the `printed` ones.
PrintShape print_shape(const BoardPlaces& places, const BoardPlaces& printed) {
  // Coordinates u, v from -1 to 1 over the board.
  const auto count = static_cast<Eigen::Index>(printed.size());
  const Eigen::Map<const Eigen::Matrix3Xd> is(places.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> ought(printed.front().data(), 3, count);
  const Eigen::Vector3d least = ought.rowwise().minCoeff(), most = ought.rowwise().maxCoeff();
  const Eigen::ArrayXd u = (2 * ought.row(0).array() - most.x() - least.x()) / (most - least).x();
  const Eigen::ArrayXd v = (2 * ought.row(1).array() - most.y() - least.y()) / (most - least).y();

  Eigen::MatrixXd terms(count, 6);
  terms << Eigen::VectorXd::Ones(count), u, v, u * u, u * v, v * v;

  // 1. Bend: the largest quadratic term of the heights.
  PrintShape shape{.size = (most - least).norm()};
  const Fitted heights = fitted(terms, is.row(2).transpose());
  for (const Eigen::Index term : {3, 4, 5}) {
    if (std::abs(heights.values[term]) < shape.bend) continue;
    shape.bend = std::abs(heights.values[term]);
    shape.bend_deviation = heights.deviations[term];
  }

  // 2. Stretch: the scale of the columns over the rows', from the linear terms.
  const Fitted across = fitted(terms.leftCols<3>(), is.row(0).transpose());
  const Fitted down = fitted(terms.leftCols<3>(), is.row(1).transpose());
  const double wide = (most - least).x() / 2, high = (most - least).y() / 2;
  shape.stretch = down.values[2] / high / (across.values[1] / wide) - 1;
  shape.stretch_deviation = std::hypot(down.deviations[2] / high, across.deviations[1] / wide);
  return shape;
}

/// Evaluates each of `poses` with a calibration of the others; returns the scanners of these
/// calibrations.
std::vector<Scanner> leave_each_out(const BoardViews& views, const BundleState& state,
                                    const BoardPlaces& printed, BundleSettings settings,
                                    const ResidualDegrees& residual,
                                    std::vector<CalibratedPose>& poses) {
  settings.pixel_deviations = pixel_deviations(views, state);

  const auto count = static_cast<double>(views.size());
  const double all = count * mean_squared_error(views, state, *settings.pixel_deviations);
  std::vector<Scanner> scanners(views.size());

  for_each_row(static_cast<int>(views.size()), [&](int pose) {
    SomePoses others =
        some_poses(views, state, [&](std::size_t i) { return std::cmp_not_equal(i, pose); });
    const BundleState rest =
        adjusted_with_residual(others.views, std::move(others.state), printed, settings, residual);

    const double of_others = mean_squared_error(others.views, rest, *settings.pixel_deviations);
    poses[pose].left_out = board_quality(views[pose], rest.scanner, printed);
    poses[pose].offset =
        projector_offset(views[pose], rest.scanner, state.poses[pose], rest.places);

    // How much the pose adds to the sum over the others: 1 if it fits as well as they do.
    poses[pose].misfit = all / of_others - (count - 1);
    scanners[pose] = rest.scanner;
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

/// Depths of the nearest and the farthest corner of all boards.
DepthRange depths_of(const BoardViews& views, const BundleState& state) {
  DepthRange range{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const int place : views[v].places) {
      const double depth = (state.poses[v] * state.places[place]).z();
      range = {std::min(range.nearest, depth), std::max(range.farthest, depth)};
    }
  }
  return range;
}

void require_known_model(const std::optional<int>& coefficients, const char* device) {
  if (!coefficients || std::ranges::count(lens_models, *coefficients) > 0) return;
  throw Error(fmt::format("{} distortion coefficients for the {}: expected one of {}",
                          *coefficients, device, fmt::join(lens_models, ", ")));
}

/// Mean squared error of a fold's held-out poses.
double left_out_error(const BoardViews& views, BundleState state, const BundleSettings& settings,
                      std::size_t fold) {
  forget_held_coefficients(state.scanner, settings);
  const SomePoses explained = explained_fold(views, state, settings, {}, fold);
  return mean_squared_error(explained.views, explained.state, *settings.pixel_deviations);
}

/// The model that is `asked` for, else the simplest that the data support: calibrates each model
/// without some of the poses and evaluates it on these, with only the board's pose free. Returns
/// the model with the fewest coefficients that is not worse than the best by more than the standard
/// error of the difference; does not try k1 k2 without tangential coefficients. `state`: start of
/// the calibrations; the board's corners are fixed.
LensChoice chosen_model(const std::optional<int>& asked, const BoardViews& views,
                        const BundleState& state, Device device) {
  if (asked) return {*asked, {}};

  const std::size_t folds = fold_count(views.size());

  // Four for the other device: an unsupported fifth could spoil the predictions.
  BundleSettings settings{.camera_coefficients = 4, .projector_coefficients = 4};
  settings.pixel_deviations = pixel_deviations(views, state);

  std::vector<std::vector<double>> errors;
  std::size_t best = 0;
  LensChoice choice;

  for (const int coefficients : lens_models) {
    // Without tangential coefficients the principal point absorbs their effect, and its standard
    // deviation does not reveal that.
    if (coefficients == 2) continue;

    (device == Device::camera ? settings.camera_coefficients : settings.projector_coefficients) =
        coefficients;

    std::vector<double> by_fold(folds);
    for_each_row(static_cast<int>(folds),
                 [&](int fold) { by_fold[fold] = left_out_error(views, state, settings, fold); });

    errors.push_back(by_fold);
    choice.scores.push_back({coefficients, std::sqrt(mean_of(by_fold))});
    if (mean_of(by_fold) < mean_of(errors[best])) best = errors.size() - 1;

    // Two larger models in a row without a smaller error.
    const bool gains_nothing_more = errors.size() > best + 2;
    if (gains_nothing_more) break;
  }

  // The simplest model that is not clearly worse than the best.
  std::size_t chosen = 0;
  while (chosen < best && clearly_worse(errors[chosen], errors[best])) ++chosen;
  choice.coefficients = choice.scores[chosen].coefficients;
  return choice;
}

/// The degrees of the residual maps that the poses support: the camera's first, as all corners are
/// seen by it.
ResidualDegrees residual_degrees(const BoardViews& views, const BundleState& state,
                                 BundleSettings bundle, GeometryCalibration& result) {
  // The board's corners stay where they are: a fold has too few to estimate them.
  bundle.print_deviation = std::nullopt;
  bundle.pixel_deviations = pixel_deviations(views, state);

  ResidualDegrees degrees;
  result.camera_residual = chosen_residual(views, state, bundle, Device::camera, degrees);
  degrees.camera = result.camera_residual.degree;
  result.projector_residual = chosen_residual(views, state, bundle, Device::projector, degrees);
  degrees.projector = result.projector_residual.degree;
  return degrees;
}

/// Adds the poses with their reprojection errors, and those of all.
void add_reprojections(const BoardViews& views, GeometryCalibration& result) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.poses.push_back({.name = views[v].name,
                            .corners = static_cast<int>(views[v].places.size()),
                            .lit = lit_corners(views[v]),
                            .rms = reprojection(views[v], result.state, v).rms()});
  }

  result.rms = reprojection(views, result.state).rms();
  result.state.scanner.calibration_rms = result.rms.stereo;
}

/// The places of the board's corners. The shape of a print that is taken for exact shows only if
/// its corners are freed.
BoardPlaces freed_places(const BoardViews& views, const BoardPlaces& printed, double spacing,
                         const BundleState& state, BundleSettings bundle) {
  if (bundle.print_deviation) return state.places;

  bundle.print_deviation = *GeometryCalibrationSettings{}.print_deviation * spacing;
  return bundle_adjusted(views, state, printed, bundle).places;
}

}  // namespace

const char* name_of_lens_model(int coefficients) {
  static const std::map<int, const char*> names{{0, "none"},
                                                {1, "k1"},
                                                {2, "k1 k2"},
                                                {4, "k1 k2, tangential"},
                                                {5, "k1 k2 k3, tangential"},
                                                {8, "rational, tangential"},
                                                {12, "rational, tangential, thin prism"}};
  return names.at(coefficients);
}

std::optional<int> lens_model_named(const std::string& text, const std::string& name) {
  if (text == "auto") return std::nullopt;
  for (const int count : lens_models) {
    if (text == std::to_string(count)) return count;
  }
  throw Error(
      fmt::format("{} '{}': expected auto or one of {}", name, text, fmt::join(lens_models, ", ")));
}

GeometryCalibration calibrate_geometry(BoardViews views, const CalibrationBoard& board, Size camera,
                                       Size projector,
                                       const GeometryCalibrationSettings& settings) {
  require_valid(board);
  return calibrate_geometry(std::move(views), printed_places(board), board.spacing, camera,
                            projector, settings);
}

GeometryCalibration calibrate_geometry(BoardViews views, const BoardPlaces& printed, double spacing,
                                       Size camera, Size projector,
                                       const GeometryCalibrationSettings& settings) {
  require_known_model(settings.camera_coefficients, "camera");
  require_known_model(settings.projector_coefficients, "projector");
  throw_if(views.size() < fewest_poses, "{} usable poses; at least {} are required, take ten",
           views.size(), fewest_poses);

  views = checked_views(std::move(views), printed);

  // 1. A simple calibration, to see whether all poses are of one rig.
  GeometryCalibration result;
  BundleState& state = result.state;
  state = simple_calibration(views, printed, camera, projector);
  require_one_rig(views, state, printed);

  // 2. The lens models that the data support.
  BundleSettings bundle;
  if (settings.print_deviation) bundle.print_deviation = *settings.print_deviation * spacing;
  state = bundle_adjusted(views, std::move(state), printed, bundle);
  result.camera_lens = chosen_model(settings.camera_coefficients, views, state, Device::camera);
  result.projector_lens =
      chosen_model(settings.projector_coefficients, views, state, Device::projector);

  // 3. The calibration itself, with residual maps if asked for, and the standard deviations of its
  //    parameters.
  bundle.camera_coefficients = result.camera_lens.coefficients;
  bundle.projector_coefficients = result.projector_lens.coefficients;
  forget_held_coefficients(state.scanner, bundle);
  const ResidualDegrees residual =
      settings.residual ? residual_degrees(views, state, bundle, result) : ResidualDegrees{};
  state =
      adjusted_with_residual(views, std::move(state), printed, bundle, residual, &result.deviation);
  state.scanner.calibrated_depths = depths_of(views, state);
  require_valid(state.scanner);

  // 4. Figures for each pose and for all.
  add_reprojections(views, result);
  result.deviation = widened(result.deviation,
                             leave_each_out(views, state, printed, bundle, residual, result.poses));

  result.covered_camera = covered_share(coverage_map(views, Device::camera, camera));
  result.covered_projector = covered_share(coverage_map(views, Device::projector, projector));
  result.largest_tilt = largest_angle(state.poses);
  result.moved = moved_rig(views, state);
  result.print = print_shape(freed_places(views, printed, spacing, state, bundle), printed);
  result.views = std::move(views);

  result.findings = findings_about(result);
  return result;
}

}  // namespace slipstream
