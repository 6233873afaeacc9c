#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/calibrate/geometry_calibration.h"

namespace slipstream {
namespace {

/// Of few poses one is left out at a time; of many a quarter, for the time it takes.
std::size_t fold_count(std::size_t poses) {
  constexpr std::size_t few = 6, parts = 4;
  return poses <= few ? poses : parts;
}

/// Mean squared error of the poses that a fold leaves out.
double left_out_error(const std::vector<BoardView>& views, const BundleState& state,
                      BundleSettings settings, std::size_t fold, std::size_t folds) {
  const auto is_left_out = [&](std::size_t pose) { return pose % folds == fold; };
  SomePoses kept = some_poses(views, state, std::not_fn(is_left_out));
  forget_held_coefficients(kept.state.scanner, settings);
  const BundleState calibrated =
      bundle_adjusted(kept.views, std::move(kept.state), state.places, settings);

  SomePoses left_out = some_poses(views, state, is_left_out);
  left_out.state.scanner = calibrated.scanner;
  settings.hold_camera = settings.hold_projector = settings.hold_rig = true;
  const BundleState explained =
      bundle_adjusted(left_out.views, std::move(left_out.state), state.places, settings);
  return mean_squared_error(left_out.views, explained, *settings.pixel_deviations);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Whether `errors` are worse than `best`, fold by fold, by more than the standard error, and by
/// more than the half percent for which nobody wants further coefficients.
bool clearly_worse(const std::vector<double>& errors, const std::vector<double>& best) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < errors.size(); ++i) differences.push_back(errors[i] - best[i]);
  const double average = mean(differences);
  double squares = 0;
  for (const double difference : differences) squares += std::pow(difference - average, 2);
  const auto n = static_cast<double>(differences.size());
  constexpr double least_share = 0.005;
  return average > std::sqrt(squares / (n - 1) / n) && average > least_share * mean(best);
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

LensChoice choose_lens_model(const std::vector<BoardView>& views, const BundleState& state,
                             Device device) {
  const std::size_t folds = fold_count(views.size());
  // Four of the other device: a fifth that is not there may spoil what is foreseen.
  BundleSettings settings{.camera_coefficients = 4, .projector_coefficients = 4};
  settings.pixel_deviations = pixel_deviations(views, state);
  std::vector<std::vector<double>> errors;
  std::size_t best = 0;
  LensChoice choice;
  for (const int coefficients : lens_models) {
    // Without the tangential ones the principal point takes their place, and no standard deviation
    // says so.
    if (coefficients == 2) continue;
    (device == Device::camera ? settings.camera_coefficients : settings.projector_coefficients) =
        coefficients;
    std::vector<double> by_fold(folds);
    for_each_row(static_cast<int>(folds), [&](int fold) {
      const auto f = static_cast<std::size_t>(fold);
      by_fold[f] = left_out_error(views, state, settings, f, folds);
    });
    errors.push_back(by_fold);
    choice.scores.push_back({coefficients, std::sqrt(mean(by_fold))});
    if (mean(by_fold) < mean(errors[best])) best = errors.size() - 1;
    const bool gains_nothing_more = errors.size() > best + 2;
    if (gains_nothing_more) break;
  }
  std::size_t chosen = 0;
  while (chosen < best && clearly_worse(errors[chosen], errors[best])) ++chosen;
  choice.coefficients = choice.scores[chosen].coefficients;
  return choice;
}

std::optional<int> lens_model_named(const std::string& text, const std::string& name) {
  if (text == "auto") return std::nullopt;
  for (const int count : lens_models) {
    if (text == std::to_string(count)) return count;
  }
  throw Error(fmt::format("{} {} is not known; it is auto or one of {}", name, text,
                          fmt::join(lens_models, ", ")));
}

}  // namespace slipstream
