#include "scan_job/error_budget.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/numbers.h"
#include "check/waveform.h"
#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"
#include "reconstruct/edge_sigma.h"
#include "response/correction.h"

namespace slipstream {
namespace {

/// An error of the projector coordinate that repeats from scan to scan.
struct SystematicError {
  std::optional<double> coordinate;  ///< standard deviation, fields; nullopt if unknown
  std::string found;                 ///< see ErrorSource
};

/// Means over the points.
struct PointMeans {
  double noise = 0, quantisation = 0, edges = 0;  ///< squares of depth errors, mm^2
  double depth_by_coordinate = 0;                 ///< square of the change of depth, mm per field
  double motion = 0;                              ///< square of the phase change per frame, rad
};

/// Variance of rounding, grey levels of 255.
double rounding_variance(const FrameViews& frames) {
  if (!frames.quantised()) return 0;
  return quantisation_variance * std::pow(255 / frames.full_scale(), 2);
}

/// Whether blur reaches a pixel from a step between surfaces, or from a pixel that was cleaned
/// away. `noise`: standard deviation of depth, mm.
bool is_near_step(const Cloud& cloud, int column, int row, double noise) {
  constexpr int reach = 2;  // pixels
  constexpr double steep = EdgeModel::steep;
  const Eigen::Vector3d here = position_at(cloud, column, row);

  const int last_row = std::min(row + reach, cloud.size().height - 1);
  const int last_column = std::min(column + reach, cloud.size().width - 1);
  for (int y = std::max(row - reach, 0); y <= last_row; ++y) {
    for (int x = std::max(column - reach, 0); x <= last_column; ++x) {
      const Validity validity = cloud.validity(x, y);
      if (validity == Validity::mixed || validity == Validity::outlier ||
          validity == Validity::small_component) {
        return true;
      }
      if (validity != Validity::valid) continue;

      // A step between the two pixels beside is half as steep from here.
      const bool is_beside = std::abs(x - column) < reach && std::abs(y - row) < reach;
      const Eigen::Vector3d there = position_at(cloud, x, y);
      if (on_one_surface(here, there, is_beside ? steep : steep / 2)) continue;
      if ((there - here).norm() > EdgeModel::deviations * noise) return true;
    }
  }
  return false;
}

PointMeans means_of(const ScanResult& result, const FrameViews& frames) {
  const auto& [scanner, sequence, settings] = result.setup;
  const Uncertainty& sigma = *result.uncertainty;
  const Maps& maps = result.maps;
  const Cloud& cloud = result.cloud;
  const double grey_level = frames.full_scale() / 255;
  const double variance = scanner.photometry.noise_variance.value_or(CueSettings{}.noise_variance);
  const double half_period = 0.5 / measuring_band(sequence.strategy.layout()).periods;  // fields

  PointMeans means;
  double count = 0;
  for_each_pixel_in_order(sigma.z.size(), [&](int column, int row) {
    const double z = sigma.z(column, row), of_noise = std::pow(sigma.z_of_noise(column, row), 2);
    if (!std::isfinite(z)) return;
    ++count;
    const double by_coordinate = z / sigma.coordinate(column, row);  // mm per field

    // The noise variance includes rounding. Codes have no mean.
    const double mean = maps.mean.empty() ? 0 : maps.mean(column, row) / grey_level;
    const double all_noise = noise_variance_at(mean, variance, scanner.photometry.noise_gain);
    const double rounded = std::min(1.0, rounding_variance(frames) / all_noise) * of_noise;
    means.quantisation += rounded;
    means.noise += of_noise - rounded;
    means.depth_by_coordinate += by_coordinate * by_coordinate;
    if (!maps.motion.empty()) means.motion += std::pow(maps.motion(column, row), 2);

    // Beside a step sigma covers that a pixel sees either surface. Its point lies on that surface,
    // pulled by the share of the other one that a lens mixes in, whose phase is at most half a
    // period away.
    double edge = std::sqrt(std::max(0.0, z * z - of_noise));
    if (is_near_step(cloud, column, row, std::sqrt(of_noise))) {
      const double step = edge / EdgeModel::off_centre;
      edge = EdgeModel::by_lens * std::min(step, half_period * by_coordinate);
    }
    means.edges += edge * edge;
  });

  for (double* const sum : {&means.noise, &means.quantisation, &means.edges,
                            &means.depth_by_coordinate, &means.motion}) {
    *sum /= std::max(count, 1.0);
  }
  return means;
}

/// RMS over the phases of the error, rad, that the standard error of a gamma leaves after
/// correction.
double phase_error_by(const MeasuredResponse& response, int steps) {
  constexpr int phases = 64;
  const PowerLaw used{response.gamma}, other{response.gamma + response.standard_error};

  double squares = 0;
  for (int i = 0; i < phases; ++i) {
    const double phi = 2 * std::numbers::pi * i / phases;
    squares += std::pow(phase_error(other, steps, phi) - phase_error(used, steps, phi), 2);
  }
  return std::sqrt(squares / phases);
}

SystematicError gamma_left(const EngineSetup& setup, const FrameViews& frames) {
  const Band& band = measuring_band(setup.sequence.strategy.layout());
  const double fields = 1 / (2 * std::numbers::pi * band.periods);  // of a radian
  const PhotometricCalibration& photometry = setup.scanner.photometry;

  // 1. The frames show it, after correction.
  const auto shown =
      phase_error_left(frames, setup.sequence, photometry, setup.settings.minimum_modulation);
  if (shown) return {fields * *shown, "harmonics in the frames"};

  // 2. Else the correction is as good as the response.
  const std::optional<StepRun> run = bent_run(band);
  const auto& response = photometry.response;
  if (run && response && response->standard_error > 0) {
    return {fields * phase_error_by(*response, run->steps),
            fmt::format("standard error {:.2g} of gamma", response->standard_error)};
  }
  return {std::nullopt, "these patterns do not show it; four steps or more do"};
}

/// Errors of the calibration and of its lens models, which both axes of the projector show across
/// the epipolar lines. They are taken to be as large along them.
std::pair<SystematicError, SystematicError> calibration_left(const ScanResult& result) {
  const auto& [scanner, sequence, settings] = result.setup;
  const double fields = 1.0 / length_along(sequence.axis, scanner.projector.size);  // of a pixel

  // 1. The distances over the picture: RMS of a constant and a linear part, and of the rest.
  if (const auto& epipolar = result.epipolar ? result.epipolar : result.guard) {
    const double pose = std::hypot(epipolar->constant, epipolar->linear / std::sqrt(3.0));
    const double lens = epipolar->quadratic / std::sqrt(5.0);
    return {
        {fields * pose, "distance from the epipolar lines, constant and linear over the picture"},
        {fields * lens, "the same, quadratic over the picture"}};
  }

  // 2. Else the reprojection error, which has both.
  const char* const shown = "patterns along both axes, or a guard, show it";
  if (scanner.calibration_rms > 0) {
    return {{fields * scanner.calibration_rms,
             fmt::format("reprojection error, {:.2g} pixels", scanner.calibration_rms)},
            {std::nullopt, fmt::format("part of the calibration's; {}", shown)}};
  }
  return {{std::nullopt, shown}, {std::nullopt, shown}};
}

/// What compensation in a window longer than a cycle leaves of the motion during the cycle: 5 % at
/// 0.04 rad, 26 % at 0.4, see FrameMotion.
SystematicError motion_left(const EngineSetup& setup, const PointMeans& means) {
  const Band& band = measuring_band(setup.sequence.strategy.layout());
  if (!band.cycle) return {std::nullopt, "one cycle of the patterns does not show it"};

  const double moved = std::sqrt(means.motion) * band.cycle->steps;  // rad
  const double share = std::min(1.0, 0.027 + 0.58 * moved);
  return {share * moved / (2 * std::numbers::pi * band.periods), "phase change over the window"};
}

}  // namespace

double ErrorBudget::total() const {
  double squares = 0;
  for (const ErrorSource& source : sources) squares += std::pow(source.depth.value_or(0), 2);
  return std::sqrt(squares);
}

ErrorBudget error_budget(ScanResult& result, const FrameViews& frames) {
  const EngineSetup& setup = result.setup;
  const bool of_stripes = setup.sequence.strategy.layout().unwrapping->whole_stripes;
  const auto& noise_variance = setup.scanner.photometry.noise_variance;
  const PointMeans means = means_of(result, frames);
  ErrorBudget budget;

  // 1. The sources in the uncertainty of the points.
  if (of_stripes) {
    budget.sources.push_back(
        {"stripes", std::sqrt(means.noise + means.quantisation), "width of the code's stripes"});
  } else {
    budget.sources.push_back(
        {"noise", std::sqrt(means.noise),
         noise_variance
             ? fmt::format("noise variance {:.3g}, at half of full scale", *noise_variance)
             : "noise variance unknown, 1.6 assumed"});
    budget.sources.push_back({"quantisation", std::sqrt(means.quantisation),
                              fmt::format("camera of {} bits", frames.bits())});
  }
  budget.sources.push_back(
      {"blur at edges", std::sqrt(means.edges), "steps, shadows and contrast beside a pixel"});

  // 2. Errors of the projector coordinate that all points share.
  const auto [calibration, lens] = calibration_left(result);
  const SystematicError gamma = gamma_left(setup, frames), motion = motion_left(setup, means);
  double squares = 0;  // fields^2
  bool any_known = false;
  for (const auto& [name, error] :
       {std::pair("gamma", &gamma), std::pair("motion", &motion),
        std::pair("calibration", &calibration), std::pair("lens model", &lens)}) {
    const double depth = std::sqrt(means.depth_by_coordinate) * error->coordinate.value_or(0);
    budget.sources.push_back(
        {name, error->coordinate ? std::optional(depth) : std::nullopt, error->found});
    squares += std::pow(error->coordinate.value_or(0), 2);
    any_known |= error->coordinate.has_value();
  }
  if (!any_known) return budget;

  // 3. The same for each point.
  Uncertainty& sigma = *result.uncertainty;
  sigma.z_systematic = sigma.z;
  for (std::size_t i = 0; i < sigma.z.pixel_count(); ++i) {
    const double by_coordinate = sigma.z.begin()[i] / sigma.coordinate.begin()[i];
    sigma.z_systematic.begin()[i] = static_cast<float>(std::sqrt(squares) * by_coordinate);
  }
  return budget;
}

}  // namespace slipstream
