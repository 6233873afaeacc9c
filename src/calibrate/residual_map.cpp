#include "calibrate/residual_map.h"

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "calibrate/left_out.h"
#include "calibrate/reprojection.h"
#include "geometry/lens_residual.h"

namespace slipstream {
namespace {

// Beyond its field the projector's map continues as a polynomial, which high degrees would spoil.
constexpr std::array camera_degrees{2, 3, 4, 6, 8, 10, 12, 14};
constexpr std::array projector_degrees{2, 3, 4};

Lens& device_lens(Scanner& scanner, Device device) {
  return device == Device::camera ? scanner.camera : scanner.projector;
}

int& degree_of(ResidualDegrees& degrees, Device device) {
  return device == Device::camera ? degrees.camera : degrees.projector;
}

/// The map that fits a device's corners: their errors plus the shift by the present map.
LensResidual fitted_map(const BoardViews& views, const BundleState& state, Device device,
                        int degree) {
  Scanner scanner = state.scanner;
  const Lens& lens = device_lens(scanner, device);

  std::vector<ResidualSample> samples;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const PixelPlaces& corners = corners_of(views[v], device);
    const PixelPlaces offs = residuals(views[v], state, v, device);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d off = offs[i] + shift_at(lens.residual, corners[i]);
      if (!off.allFinite()) continue;
      samples.push_back({corners[i], Eigen::Vector2d::UnitX(), off.x()});
      samples.push_back({corners[i], Eigen::Vector2d::UnitY(), off.y()});
    }
  }
  return fitted_residual(samples, lens.size, degree);
}

}  // namespace

BundleState adjusted_with_residual(const BoardViews& views, BundleState start,
                                   const BoardPlaces& printed, const BundleSettings& settings,
                                   const ResidualDegrees& degrees, BundleDeviation* deviation) {
  // Lenses, poses and maps share much of the corners' errors: a few rounds settle which.
  constexpr int rounds = 3;

  BundleState state = std::move(start);
  const bool has_maps = degrees.camera > 0 || degrees.projector > 0;
  for (int round = 0; round < rounds && has_maps; ++round) {
    state = bundle_adjusted(views, std::move(state), printed, settings);
    for (const auto& [device, degree] : {std::pair(Device::camera, degrees.camera),
                                         std::pair(Device::projector, degrees.projector)}) {
      if (degree == 0) continue;
      LensResidual map = fitted_map(views, state, device, degree);
      device_lens(state.scanner, device).residual = std::move(map);
    }
  }

  return bundle_adjusted(views, std::move(state), printed, settings, deviation);
}

SomePoses explained_fold(const BoardViews& views, const BundleState& state, BundleSettings settings,
                         const ResidualDegrees& degrees, std::size_t fold) {
  const std::size_t folds = fold_count(views.size());
  const auto is_left_out = [&](std::size_t pose) { return pose % folds == fold; };

  // 1. A calibration by the other poses.
  SomePoses kept = some_poses(views, state, std::not_fn(is_left_out));
  const BundleState calibrated =
      adjusted_with_residual(kept.views, std::move(kept.state), state.places, settings, degrees);

  // 2. The fold's poses under that calibration: only they may move.
  SomePoses left_out = some_poses(views, state, is_left_out);
  left_out.state.scanner = calibrated.scanner;
  settings.hold_camera = settings.hold_projector = settings.hold_rig = true;
  left_out.state =
      bundle_adjusted(left_out.views, std::move(left_out.state), state.places, settings);
  return left_out;
}

ResidualChoice chosen_residual(const BoardViews& views, const BundleState& state,
                               const BundleSettings& settings, Device device,
                               const ResidualDegrees& degrees) {
  throw_if(views.size() < fewest_residual_poses,
           "{} usable poses; a residual map requires {}: take more, or calibrate without it",
           views.size(), fewest_residual_poses);

  std::vector<int> tried{0};
  for (const int degree : device == Device::camera ? std::span<const int>(camera_degrees)
                                                   : std::span<const int>(projector_degrees)) {
    tried.push_back(degree);
  }

  const std::size_t folds = fold_count(views.size());
  std::vector<std::vector<double>> errors;
  ResidualChoice choice;
  std::size_t best = 0;

  for (const int degree : tried) {
    ResidualDegrees with = degrees;
    degree_of(with, device) = degree;

    // 1. The error of each fold's poses under a calibration of the others.
    std::vector<double> by_fold(folds), pixels(folds);
    for_each_row(static_cast<int>(folds), [&](int fold) {
      const SomePoses explained = explained_fold(views, state, settings, with, fold);
      by_fold[fold] =
          mean_squared_error(explained.views, explained.state, *settings.pixel_deviations);

      const Reprojection all = reprojection(explained.views, explained.state);
      const double rms = device == Device::camera ? all.camera.rms() : all.projector.rms();
      pixels[fold] = rms * rms;
    });

    errors.push_back(by_fold);
    choice.scores.push_back({degree, std::sqrt(mean_of(by_fold)), std::sqrt(mean_of(pixels))});
    if (mean_of(by_fold) < mean_of(errors[best])) best = errors.size() - 1;
  }

  // 2. The lowest degree that is not clearly worse than the best.
  std::size_t chosen = 0;
  while (chosen < best && clearly_worse(errors[chosen], errors[best])) ++chosen;
  choice.degree = choice.scores[chosen].degree;
  return choice;
}

}  // namespace slipstream
