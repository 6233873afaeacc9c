#include "slipstream/calibrate/lens_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// One device alone, in the camera's place.
struct OneDevice {
  std::vector<BoardView> views;
  BundleState state;
};

OneDevice alone(std::vector<BoardView> views, BundleState state, Device device) {
  if (device == Device::projector) {
    Eigen::Isometry3d to_projector = Eigen::Isometry3d::Identity();
    to_projector.linear() = state.scanner.rotation;
    to_projector.translation() = state.scanner.translation;
    state.scanner.camera = state.scanner.projector;
    for (Eigen::Isometry3d& pose : state.poses) pose = to_projector * pose;
  }
  for (BoardView& view : views) {
    if (device == Device::projector) view.camera = view.projector;
    view.projector.assign(view.places.size(), {nan, nan});
  }
  return {std::move(views), std::move(state)};
}

/// Poses that are left out together: every `most_folds`th.
constexpr std::size_t most_folds = 6;

/// Some poses of a device, and the rest.
struct Split {
  OneDevice kept, left_out;
};

Split split(const OneDevice& device, std::size_t fold, std::size_t folds) {
  Split result;
  result.kept.state.scanner = result.left_out.state.scanner = device.state.scanner;
  result.kept.state.places = result.left_out.state.places = device.state.places;
  for (std::size_t pose = 0; pose < device.views.size(); ++pose) {
    OneDevice& part = pose % folds == fold ? result.left_out : result.kept;
    part.views.push_back(device.views[pose]);
    part.state.poses.push_back(device.state.poses[pose]);
  }
  return result;
}

/// Mean squared distance of the corners of the poses that a fold leaves out, pixels^2.
double left_out_error(const OneDevice& device, int coefficients, std::size_t fold,
                      std::size_t folds) {
  auto [kept, left_out] = split(device, fold, folds);
  auto& k = kept.state.scanner.camera.distortion.coefficients;
  std::fill(k.begin() + coefficients, k.end(), 0.0);
  const std::vector<Eigen::Vector3d>& places = device.state.places;
  const BundleState calibrated =
      bundle_adjusted(kept.views, std::move(kept.state), places,
                      {.camera_coefficients = coefficients, .rounds = 1});

  left_out.state.scanner = calibrated.scanner;
  const BundleState explained = bundle_adjusted(left_out.views, std::move(left_out.state), places,
                                                {.hold_camera = true, .rounds = 1});
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < left_out.views.size(); ++v) {
    for (const Eigen::Vector2d& residual : camera_residuals(left_out.views[v], explained.scanner,
                                                            explained.poses[v], explained.places)) {
      if (!residual.allFinite()) continue;
      sum += residual.squaredNorm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Whether `errors` are worse than `best`, fold by fold, by more than the standard error.
bool clearly_worse(const std::vector<double>& errors, const std::vector<double>& best) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < errors.size(); ++i) differences.push_back(errors[i] - best[i]);
  const double average = mean(differences);
  double squares = 0;
  for (const double difference : differences) squares += std::pow(difference - average, 2);
  const auto n = static_cast<double>(differences.size());
  return average > std::sqrt(squares / (n - 1) / n);
}

}  // namespace

const char* name_of_lens_model(int coefficients) {
  switch (coefficients) {
    case 0:
      return "none";
    case 1:
      return "k1";
    case 2:
      return "k1 k2";
    case 4:
      return "k1 k2, tangential";
    case 5:
      return "k1 k2 k3, tangential";
    case 8:
      return "rational, tangential";
    default:
      return "rational, tangential, thin prism";
  }
}

LensChoice choose_lens_model(const std::vector<BoardView>& views, const BundleState& state,
                             Device device) {
  const OneDevice one = alone(views, state, device);
  const std::size_t folds = std::min(views.size(), most_folds);
  std::vector<std::vector<double>> errors(lens_models.size(), std::vector<double>(folds));
  for_each_row(static_cast<int>(lens_models.size() * folds), [&](int task) {
    const auto model = static_cast<std::size_t>(task) / folds;
    const auto fold = static_cast<std::size_t>(task) % folds;
    errors[model][fold] = left_out_error(one, lens_models[model], fold, folds);
  });

  std::size_t best = 0;
  LensChoice choice;
  for (std::size_t model = 0; model < lens_models.size(); ++model) {
    if (mean(errors[model]) < mean(errors[best])) best = model;
    choice.scores.push_back({lens_models[model], std::sqrt(mean(errors[model]))});
  }
  std::size_t chosen = 0;
  while (chosen < best && clearly_worse(errors[chosen], errors[best])) ++chosen;
  choice.coefficients = lens_models[chosen];
  return choice;
}

}  // namespace slipstream
