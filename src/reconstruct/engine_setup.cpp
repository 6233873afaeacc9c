#include "reconstruct/engine_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "geometry/triangulator.h"
#include "response/correction.h"
#include "slipstream/strategy.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void require_valid(const ReconstructSettings& settings) {
  require_in_range(settings);

  const double nearest = settings.nearest.value_or(0);
  const double farthest = settings.farthest.value_or(infinity);
  require_in_range({.name = "nearest_depth", .unit = "mm", .least = 0}, nearest);
  throw_if(!(farthest > nearest),
           "farthest depth {} mm is out of range; it must be more than the nearest", farthest);

  require_valid(settings.clean);
}

}  // namespace

void require_size(const FrameViews& frames, Size camera) {
  if (frames.size() == camera) return;
  throw Error(fmt::format("frames are {}, the scanner's camera has {}; both must agree",
                          text_of(frames.size()), text_of(camera)));
}

bool unwraps_by_depth(const EngineSetup& setup) {
  return !has_coordinate(setup.sequence.strategy) && setup.settings.nearest &&
         setup.settings.farthest;
}

bool unwraps_by_picture(const EngineSetup& setup) {
  return unwraps_by_depth(setup) ||
         order_source(setup.sequence.strategy.layout()) == OrderSource::surface;
}

CueSettings cue_settings(const EngineSetup& setup) {
  const PhotometricCalibration& known = setup.scanner.photometry;
  CueSettings cue{.light = setup.sequence.light, .rule = setup.settings.cue_rule};

  // A calibrated value replaces the default.
  cue.ambient = known.ambient.value_or(cue.ambient);
  cue.noise_variance = known.noise_variance.value_or(cue.noise_variance);

  return cue;
}

PhaseCorrections phase_corrections(const EngineSetup& setup) {
  const auto& measured = setup.scanner.photometry.response;
  if (!measured) return {};
  return phase_corrections(measured->response, setup.sequence.strategy.layout());
}

int projector_length(const EngineSetup& setup) {
  return length_along(setup.sequence.axis, setup.scanner.projector.size);
}

double least_modulation(const EngineSetup& setup) {
  const Layout& layout = setup.sequence.strategy.layout();
  const double least = setup.settings.minimum_modulation;
  if (order_source(layout) != OrderSource::neighbours) return least;
  return std::max(least, CueEvidence(layout, cue_settings(setup)).least_modulation());
}

void raise_least_modulation(EngineSetup& setup) {
  const double least = least_modulation(setup);
  ReconstructSettings& settings = setup.settings;
  if (!(least > settings.minimum_modulation)) return;

  // The product of both stays the same, and with it the pixels that vote.
  settings.least_voting_share *= settings.minimum_modulation / least;
  settings.minimum_modulation = least;
}

double least_modulation(const ReconstructSettings& settings, double full_scale) {
  return settings.minimum_modulation * full_scale / 255;
}

double least_neighbour_modulation(const ReconstructSettings& settings, double full_scale) {
  return settings.least_voting_share * least_modulation(settings, full_scale);
}

void set_backend(ReconstructSettings& settings, std::string_view name) {
  settings.gpu.reset();

  if (name == "fused") {
    settings.engine = EngineKind::fused;
    return;
  }

  if (name == "gpu" || name.starts_with("gpu:")) {
    settings.engine = EngineKind::gpu;
    if (name == "gpu") return;

    // "gpu:0", "gpu:1", ...
    settings.gpu = number_in<int>(name.substr(4));
    if (settings.gpu.value_or(-1) >= 0) return;
    throw Error(fmt::format("backend '{}': expected gpu:NUMBER, e.g. gpu:0", name));
  }

  // The other names are phase methods of the reference engine.
  settings.engine = EngineKind::reference;
  for (const PhaseMethod method : {PhaseMethod::equation, PhaseMethod::closed_form,
                                   PhaseMethod::tables, PhaseMethod::intensity_ratio}) {
    if (name != name_of(method)) continue;
    settings.phase_method = method;
    return;
  }

  throw Error(fmt::format("unknown backend '{}'; choose {}", name, backend_forms));
}

void keep_all_points(ReconstructSettings& settings) {
  settings.clean = CleanSettings::none();
  settings.nearest = settings.nearest.value_or(0);
  settings.farthest = settings.farthest.value_or(infinity);
}

DepthRange depth_range(const EngineSetup& setup) {
  const auto& [scanner, sequence, settings] = setup;

  // Surfaces may lie outside the boards' depths, by up to a factor of two.
  DepthRange usual{0, infinity};
  if (const auto& covered = scanner.calibrated_depths) {
    usual = {covered->nearest / 2, covered->farthest * 2};
  }

  return {settings.nearest.value_or(usual.nearest), settings.farthest.value_or(usual.farthest)};
}

void require_valid(const EngineSetup& setup) {
  const auto& [scanner, sequence, settings] = setup;

  require_valid(scanner);
  require_depth_visible(scanner, sequence.axis);

  require_valid(sequence.light);
  throw_if(sequence.both_axes,
           "patterns along both axes require a finished scan; use `axis x` here");
  require_resolved(sequence.strategy, sequence.axis, scanner.projector.size);

  require_valid(settings);
}

void require_reconstructible(const EngineSetup& setup) {
  require_valid(setup);

  const Strategy& strategy = setup.sequence.strategy;
  if (has_coordinate(strategy) || unwraps_by_depth(setup)) return;

  throw Error(fmt::format(
      "{}: more than one period covers the field, so these frames alone give no depth; set "
      "`nearest` and `farthest` to a range of less than a period, or use one period, a second "
      "camera, or patterns that unwrap, such as gray-phase",
      strategy.name()));
}

void require_ambient_known(const EngineSetup& setup, std::string_view scanner) {
  const Strategy& strategy = setup.sequence.strategy;
  throw_if(needs_ambient_light(strategy.layout()) && !setup.scanner.photometry.ambient,
           "{}: the ambient light is unknown, but {} with {} frames needs it; measure it "
           "with `calibrate_ambient()`, or set `ambient_light`",
           scanner, strategy.name(), frame_count(strategy));
}

DepthNoise depth_noise(const EngineSetup& setup) {
  // The projector without its lens: rows of the coordinate and of the depth.
  const ProjectionMatrices rows = projection_matrices(setup.scanner, setup.sequence.axis);
  const auto &y = rows.projector_coordinate, &z = rows.projector_depth;

  const double variance =
      coordinate_variance(setup.sequence.strategy.layout(), 1, cue_settings(setup).noise_variance);

  // By the quotient rule, dy / dZ along a ray is (parallax P) / (Z depth^2).
  const Eigen::Vector4f depth = z.transpose().cast<float>();
  const Eigen::Vector3f parallax =
      (z(3) * y.head<3>() - y(3) * z.head<3>()).transpose().cast<float>();

  return {.noise = static_cast<float>(std::sqrt(variance)),
          .projector_depth = {depth(0), depth(1), depth(2), depth(3)},
          .parallax = {parallax(0), parallax(1), parallax(2)}};
}

}  // namespace slipstream
