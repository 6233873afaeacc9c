#include "calibrate/one_rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "calibrate/board_view.h"
#include "calibrate/bundle_adjustment.h"
#include "calibrate/diagnosis.h"
#include "calibrate/first_guess.h"
#include "calibrate/reprojection.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

auto from_to(std::size_t first, std::size_t end) {
  return [=](std::size_t pose) { return pose >= first && pose < end; };
}

/// RMS over both devices for each pose.
std::vector<double> stereo_rms(const BoardViews& views, const BundleState& state) {
  std::vector<double> rms;
  for (std::size_t v = 0; v < views.size(); ++v) {
    rms.push_back(reprojection(views[v], state, v).rms().stereo);
  }
  return rms;
}

double largest_rms(const BoardViews& views, const BundleState& state) {
  return std::ranges::max(stereo_rms(views, state));
}

/// RMS of a pose, pixels, above which it is a blunder rather than an imperfect board.
double blunder(Size camera) {
  constexpr double share_of_width = 0.003;
  constexpr double least = 1.5;
  return std::max(least, share_of_width * camera.width);
}

/// The simple calibration of some of the poses; nullopt if there is none, as with too few tilts.
std::optional<BundleState> calibration_of_some(const BoardViews& views, const BoardPlaces& printed,
                                               const Scanner& scanner) try {
  return simple_calibration(views, printed, scanner.camera.size, scanner.projector.size);
} catch (const Error&) {
  return std::nullopt;
}

/// A pose without which the others agree, and its offset under their scanner.
struct OddPose {
  std::size_t pose = 0;
  double rms_of_others = 0;  ///< the largest, pixels
  ProjectorOffset offset;
};

std::optional<OddPose> odd_pose(const BoardViews& views, const BundleState& state,
                                const BoardPlaces& printed) {
  if (views.size() <= fewest_poses) return std::nullopt;
  const double bound = blunder(state.scanner.camera.size);

  std::optional<OddPose> odd;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const BoardViews rest = some_poses(views, state, [&](std::size_t i) { return i != v; }).views;
    const auto others = calibration_of_some(rest, printed, state.scanner);
    if (!others) continue;

    const double rms = largest_rms(rest, *others);
    if (rms > bound || (odd && rms > odd->rms_of_others)) continue;
    odd = {v, rms, projector_offset(views[v], others->scanner, state.poses[v], printed)};
  }

  return odd;
}

/// A split of the poses into two rigs that each fit.
struct OtherRig {
  std::size_t first = 0;
  double rms = 0;  ///< the largest of a pose under its own rig, pixels
};

std::optional<OtherRig> other_rig(const BoardViews& views, const BundleState& state,
                                  const BoardPlaces& printed) {
  const double bound = blunder(state.scanner.camera.size);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::optional<OtherRig> other;

  for (std::size_t k = fewest_poses; k + fewest_poses <= views.size(); ++k) {
    double largest = 0;
    for (const auto& takes : {from_to(0, k), from_to(k, views.size())}) {
      const BoardViews half = some_poses(views, state, takes).views;
      const auto own = calibration_of_some(half, printed, state.scanner);
      // Poses that cannot be calibrated do not show another rig.
      largest = std::max(largest, own ? largest_rms(half, *own) : infinity);
    }

    if (largest < (other ? other->rms : bound)) other = {k, largest};
  }

  return other;
}

/// Squared error of these poses if only the rig of `state` is free.
double error_of_own_rig(const BoardViews& views, const BundleState& state, std::size_t first,
                        std::size_t end, const BundleSettings& settings) {
  SomePoses some = some_poses(views, state, from_to(first, end));
  const BundleState own =
      bundle_adjusted(some.views, std::move(some.state), state.places, settings);
  return mean_squared_error(some.views, own, *settings.pixel_deviations) *
         static_cast<double>(end - first);
}

}  // namespace

ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start, const BoardPlaces& places) {
  // The board's pose by the camera alone.
  BoardView by_camera = view;
  for (Eigen::Vector2d& pixel : by_camera.projector) pixel = {nan, nan};
  const BundleState seen = bundle_adjusted({by_camera}, {scanner, {start}, places}, places,
                                           {.hold_camera = true, .hold_rig = true});

  ProjectorOffset offset;
  int count = 0;
  for (const Eigen::Vector2d& residual :
       residuals(view, {scanner, seen.poses, places}, 0, Device::projector)) {
    if (!residual.allFinite()) continue;
    offset.mean += residual;
    offset.spread += residual.squaredNorm();
    ++count;
  }

  // Variance about the mean: mean square less squared mean.
  offset.mean /= count;
  offset.spread = std::sqrt(std::max(0.0, offset.spread / count - offset.mean.squaredNorm()));
  return offset;
}

BundleState simple_calibration(const BoardViews& views, const BoardPlaces& printed, Size camera,
                               Size projector) {
  return bundle_adjusted(views, first_guess(views, printed, camera, projector), printed,
                         {.camera_coefficients = 2, .projector_coefficients = 2});
}

void require_one_rig(const BoardViews& views, const BundleState& state,
                     const BoardPlaces& printed) {
  constexpr double most_of_median = 8;
  const double bound = blunder(state.scanner.camera.size);
  const std::vector<double> rms = stereo_rms(views, state);
  const double limit = std::max(1.5, std::min(bound, most_of_median * median(rms)));
  if (std::ranges::max(rms) < limit) return;

  // A problem common to all frames also spoils the fit.
  const std::vector<Finding> of_frames = findings_of_frames(views);
  if (!of_frames.empty()) {
    throw Error(fmt::format("the poses do not fit one camera and projector: {}",
                            text_of(of_frames.front())));
  }

  const auto odd = odd_pose(views, state, printed);
  const auto other = other_rig(views, state, printed);
  // One bad pose is the simpler cause: two rigs must fit far better.
  if (other && (!odd || other->rms < odd->rms_of_others / 2)) {
    throw Error(
        text_of(finding_of_moved_rig(views[other->first - 1].name, views[other->first].name)));
  }

  if (odd) {
    Finding finding = finding_of_pose(views[odd->pose], odd->offset);
    finding.evidence.push_back({"its RMS", rms[odd->pose], "px"});
    throw Error(text_of(finding));
  }

  throw Error(fmt::format(
      "the poses do not fit one camera and projector (median RMS {:.3g} px); likely "
      "frames of two cameras are mixed, the rig was moved between poses, or the board "
      "settings are wrong: check `board` and `corners`, or exclude some poses with `excluded`",
      median(rms)));
}

std::optional<MovedRig> moved_rig(const BoardViews& views, const BundleState& state) {
  // With five poses or fewer, two rigs also explain one bad pose.
  constexpr std::size_t fewest = 2, fewest_in_all = 6;

  BundleSettings settings{.hold_camera = true, .hold_projector = true};
  settings.pixel_deviations = pixel_deviations(views, state);
  if (views.size() < fewest_in_all) return std::nullopt;
  const double one = error_of_own_rig(views, state, 0, views.size(), settings);

  std::vector<double> two(views.size() - 2 * fewest + 1);
  for_each_row(static_cast<int>(two.size()), [&](int split) {
    const std::size_t k = split + fewest;
    two[split] = error_of_own_rig(views, state, 0, k, settings) +
                 error_of_own_rig(views, state, k, views.size(), settings);
  });

  const auto best = std::ranges::min_element(two);
  return MovedRig{(best - two.begin()) + fewest, one / *best};
}

}  // namespace slipstream
