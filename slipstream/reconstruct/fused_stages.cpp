#include "slipstream/reconstruct/fused_stages.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <variant>

#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/pattern/sinusoid.h"
#include "slipstream/phase/closed_form.h"
#include "slipstream/phase/phase_channel.h"

namespace slipstream {
namespace {

/// The sinusoids of a strategy, as far as the fused pass knows them.
struct Sinusoids {
  Sinusoid first;
  std::optional<Sinusoid> low;
  const PhaseChannelMultiplexing* multiplexed = nullptr;
};

std::optional<Sinusoids> sinusoids_of(const PhaseMeasuring& pmp, const ReconstructSettings&) {
  return Sinusoids{.first = {pmp.steps, pmp.frequency}, .low = {}};
}

std::optional<Sinusoids> sinusoids_of(const DualFrequency& dual, const ReconstructSettings&) {
  return Sinusoids{.first = {dual.steps, dual.high},
                   .low = Sinusoid{dual.low_step_count(), dual.low}};
}

std::optional<Sinusoids> sinusoids_of(const PhaseChannelMultiplexing& pcmp,
                                      const ReconstructSettings& settings) {
  constexpr double most_periods = 16384;  // shifts of whole periods are kept in 16 bits
  const bool own_reference = pcmp.steps >= 5 || !pcmp.reference;
  if (!own_reference || settings.cue.unwrapping != Unwrapping::consensus ||
      pcmp.f_h() > most_periods) {
    return std::nullopt;
  }
  return Sinusoids{.first = {pcmp.steps, pcmp.f_h()}, .low = {}, .multiplexed = &pcmp};
}

/// Any other strategy.
template <class Other>
std::optional<Sinusoids> sinusoids_of(const Other&, const ReconstructSettings&) {
  return std::nullopt;
}

/// In turns, at the part r of a period, linear between the entries.
double added_turns(const PhaseCorrection& correction, double r) {
  const auto count = static_cast<double>(correction.added.size());
  const double place = (r - std::floor(r)) * count;
  const double floor = std::floor(place);
  const auto entry = [&](double i) {
    return correction.added[static_cast<std::size_t>(i) % correction.added.size()];
  };
  return std::lerp(entry(floor), entry(floor + 1), place - floor) / (2 * std::numbers::pi);
}

/// The odd polynomial that a correction is; empty where one misses it by more than 8e-7 rad.
std::vector<float> wave_of(const PhaseCorrection& correction) {
  constexpr double largest_error = 8e-7 / (2 * std::numbers::pi);
  constexpr int nodes = 128;
  constexpr std::size_t degree = 2 * SinusoidStage::wave_terms - 1;
  // Chebyshev polynomials of x = 2 r; T_k from the two before it.
  std::vector<double> before{1}, now{0, 1}, sum(degree + 1);
  for (std::size_t k = 1; k <= degree; ++k) {
    if (k % 2 == 1) {
      double projection = 0;
      for (int i = 0; i < nodes; ++i) {
        const double angle = std::numbers::pi * (i + 0.5) / nodes;
        projection += 2.0 / nodes * added_turns(correction, std::cos(angle) / 2) *
                      std::cos(static_cast<double>(k) * angle);
      }
      for (std::size_t j = 0; j < now.size(); ++j) sum[j] += projection * now[j];
    }
    std::vector<double> next(now.size() + 1);
    for (std::size_t j = 0; j < now.size(); ++j) next[j + 1] = 2 * now[j];
    for (std::size_t j = 0; j < before.size(); ++j) next[j] -= before[j];
    before = std::exchange(now, std::move(next));
  }
  std::vector<float> wave;
  for (std::size_t power = degree; power <= degree; power -= 2) {
    wave.push_back(static_cast<float>(sum[power] * std::exp2(static_cast<double>(power))));
  }
  constexpr int samples = 1000;
  for (int i = 0; i <= samples; ++i) {
    const double r = static_cast<double>(i) / samples - 0.5;
    double slope = 0;
    for (const float c : wave) slope = slope * r * r + c;
    if (!(std::abs(slope * r - added_turns(correction, r)) <= largest_error)) return {};
  }
  return wave;
}

/// The table's N periods one after another, and the first entry once more for a turn of 1.
void add_correction(SinusoidStage& stage, const PhaseCorrection& correction) {
  stage.folded = folded_phase(correction);
  stage.correction_wave = wave_of(correction);
  if (!stage.correction_wave.empty()) return;
  const std::size_t count = correction.added.size();
  const std::size_t segments = count * static_cast<std::size_t>(stage.steps);
  const auto in_turns = [&](std::size_t i) {
    return correction.added[i % count] / (2 * std::numbers::pi);
  };
  stage.segments = static_cast<float>(segments);
  for (std::size_t i = 0; i <= segments; ++i) {
    stage.correction.push_back(static_cast<float>(in_turns(i)));
    stage.correction_rise.push_back(static_cast<float>(in_turns(i + 1) - in_turns(i)));
  }
}

SinusoidStage sinusoid_stage(int steps, const PhaseCorrections& corrections) {
  SinusoidStage stage{.steps = steps};
  const auto correction = corrections.find(steps);
  if (correction != corrections.end()) add_correction(stage, correction->second);
  const auto weigh = [&](double sine_square, double divisor) {
    stage.sine_weight = static_cast<float>(std::sqrt(sine_square));
    stage.sine_square = static_cast<float>(sine_square);
    stage.modulation_scale = static_cast<float>(1 / divisor);
  };
  if (const ClosedForm* form = closed_form(steps)) {
    weigh(form->sine_square, form->divisor);
  } else if (steps == 5) {
    weigh((5 + std::sqrt(5)) / 2, 10);  // (2 sin(2 pi / 5))^2
  } else {
    stage.cosines = channel_cosines(steps, 1);
    stage.sines = channel_sines(steps, 1);
  }
  return stage;
}

/// `frequency` measures, `widest` says within which period.
CoordinateStage coordinate_stage(double frequency, double widest, int length) {
  const double period = 1 / widest;
  return {.scale = static_cast<float>(1 / frequency),
          .period = static_cast<float>(period),
          .cut = static_cast<float>(-0.5 / length - (period - 1) / 2)};
}

ConsensusStage consensus_stage(double frequency, const FringeOrderConsensus& settings) {
  return {.half_fringe = static_cast<float>(0.5 / frequency),
          .fewest_neighbours = settings.fewest_neighbours,
          .fewest_if_doubtful = settings.fewest_if_doubtful};
}

FusedStages::LowFrequency low_frequency(const Sinusoid& low, const Sinusoid& high, int length,
                                        const ReconstructSettings& settings) {
  const FringeOrderConsensus& consensus = settings.fringe_order;
  return {.sinusoid = sinusoid_stage(low.steps, settings.phase_corrections),
          .unwrap = {.ratio = static_cast<float>(high.frequency / low.frequency),
                     .largest_doubt = static_cast<float>(consensus.largest_doubt),
                     .coordinate = coordinate_stage(high.frequency, low.frequency, length)},
          .consensus = consensus_stage(high.frequency, consensus)};
}

CueStage cue_stage(const PhaseChannelMultiplexing& pcmp, int length,
                   const ReconstructSettings& settings) {
  const PatternLight& light = settings.cue.light;
  const double dc =
      pcmp.steps == 3 ? 1 + 2 * (light.beta_p + settings.cue.ambient) / light.alpha_p : 0;
  CueStage stage{.gain = static_cast<float>(pcmp.c1() / pcmp.c2()),
                 .offset = static_cast<float>(dc / pcmp.c2()),
                 .shade = static_cast<float>(pcmp.c2() / pcmp.c1()),
                 .periods = static_cast<float>(pcmp.f_h()),
                 .largest_doubt = static_cast<float>(settings.fringe_order.largest_doubt),
                 .coordinate = coordinate_stage(pcmp.f_h(), 1, length)};
  if (pcmp.steps == 5) {
    stage.sine_weight = static_cast<float>(2 * std::sin(2 * std::numbers::pi / 5));
  } else if (pcmp.steps == 6) {
    stage.sine_weight = static_cast<float>(std::sqrt(3));
  } else if (pcmp.steps > 6) {
    stage.cosines = channel_cosines(pcmp.steps, 2);
    stage.sines = channel_sines(pcmp.steps, 2);
  }
  return stage;
}

FusedStages::Cue multiplexed(const PhaseChannelMultiplexing& pcmp, int length,
                             const ReconstructSettings& settings) {
  const int N = pcmp.steps;
  const bool circle = N >= 5;
  return {
      .stage = cue_stage(pcmp, length, settings),
      .consensus = consensus_stage(pcmp.f_h(), settings.fringe_order),
      .exact = MultiplexedCue(pcmp, settings.cue),
      .f_h = pcmp.f_h(),
      .length = length,
      .dimmest_lit = 4 * std::sqrt(2 * settings.cue.noise_variance / N),
      .ambient = N == 3 ? settings.cue.ambient : 0,
      .cosines = channel_cosines(N, 1),
      .sines = channel_sines(N, 1),
      .cue = N == 3   ? mean_weights(N)
             : N == 4 ? half_phase_weights()
                      : channel_cosines(N, 2),
      .cue_sine = circle ? channel_sines(N, 2) : std::vector<double>(static_cast<std::size_t>(N))};
}

/// A degree that the kernel is compiled for, that one or the next above.
int compiled_degree(int degree) {
  if (degree == 0) return 0;
  return std::max(3, degree + (degree % 2 == 0 ? 1 : 0));
}

std::vector<float> kernel_order(const PlanePolynomial& polynomial, int degree) {
  std::vector<float> coefficients;
  auto c = polynomial.coefficients.begin();
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      coefficients.push_back(i + j <= polynomial.degree ? static_cast<float>(*c++) : 0);
    }
  }
  std::reverse(coefficients.begin(), coefficients.end());
  return coefficients;
}

template <class Row>
PointStage::Linear linear(const Row& row) {
  return {static_cast<float>(row(0)), static_cast<float>(row(1)), static_cast<float>(row(2))};
}

std::array<float, 6> edge(const std::array<double, StripeGeometry::edge_terms>& terms) {
  std::array<float, 6> narrow{};
  std::transform(terms.begin(), terms.end(), narrow.begin(),
                 [](double c) { return static_cast<float>(c); });
  return narrow;
}

PointStage point_stage(const StripeGeometry& geometry, const ReconstructSettings& settings) {
  const int degree = compiled_degree(geometry.lens.degree);
  const auto [inner_low, inner_high] = geometry.inner_places();
  constexpr double largest = std::numeric_limits<float>::max();
  return {.coordinate = linear(geometry.coordinate),
          .depth = linear(geometry.depth),
          .facing = linear(geometry.facing),
          .place_constant = linear(geometry.place_constant),
          .place_slope = linear(geometry.place_slope),
          .coordinate_offset = static_cast<float>(geometry.coordinate(3)),
          .depth_offset = static_cast<float>(geometry.depth(3)),
          .unit_scale = static_cast<float>(geometry.unit_coordinate.scale),
          .unit_offset = static_cast<float>(geometry.unit_coordinate.offset),
          .least_coordinate = static_cast<float>(geometry.least_coordinate),
          .largest_coordinate = static_cast<float>(geometry.largest_coordinate),
          .lens_degree = degree,
          .lens = kernel_order(geometry.lens, degree),
          .low_edge = edge(geometry.low_edge),
          .high_edge = edge(geometry.high_edge),
          .inner_low = static_cast<float>(inner_low),
          .inner_high = static_cast<float>(inner_high),
          .nearest = static_cast<float>(std::min(settings.nearest, largest)),
          .farthest = static_cast<float>(std::min(settings.farthest, largest)),
          .limits_depth = settings.nearest > 0 || settings.farthest < largest};
}

/// Where the row kernel takes a turn for a coordinate as it is, without asking for the cut.
void keep_before_cut(FusedStages& stages) {
  if (!stages.blocks) return;
  const CoordinateStage& circle = stages.coordinate;
  const auto unit = [&](float y) { return y * stages.point.unit_scale + stages.point.unit_offset; };
  constexpr float apart = 1e-6F;
  for (RayBlocks::Range& range : stages.blocks->described) {
    range.least = std::max(range.least, unit(circle.cut) + apart);
    range.largest = std::min(range.largest, unit(circle.cut + circle.period) - apart);
  }
}

}  // namespace

std::optional<FusedStages> fused_stages(const Scanner& scanner, const Strategy& strategy, Axis axis,
                                        const ReconstructSettings& settings) {
  constexpr double widest_margin = 0.25;
  const auto sinusoids =
      std::visit([&](const auto& chosen) { return sinusoids_of(chosen, settings); }, strategy);
  if (!sinusoids || settings.field_margin > widest_margin ||
      scanner.camera.size.width < least_row_width) {
    return std::nullopt;
  }
  const auto geometry = stripe_geometry(scanner, axis, settings.field_margin);
  if (!geometry) return std::nullopt;
  std::optional<RayTable> rays = ray_table(scanner.camera);
  if (!rays) return std::nullopt;
  std::optional<RayBlocks> blocks = ray_blocks(*geometry, *rays);

  const auto& [first, low, pcmp] = *sinusoids;
  const int length = length_along(axis, scanner.projector.size);
  const double widest = low ? low->frequency : pcmp != nullptr ? 1 : first.frequency;
  FusedStages stages{.sinusoid = sinusoid_stage(first.steps, settings.phase_corrections),
                     .low = {},
                     .cue = {},
                     .coordinate = coordinate_stage(first.frequency, widest, length),
                     .point = point_stage(*geometry, settings),
                     .rays = std::move(*rays),
                     .blocks = std::move(blocks)};
  stages.point.may_leave_field = widest < 1;
  if (!low && pcmp == nullptr) keep_before_cut(stages);
  if (low) stages.low = low_frequency(*low, first, length, settings);
  if (pcmp != nullptr) stages.cue = multiplexed(*pcmp, length, settings);
  return stages;
}

SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double mean_of) {
  // No pixel's modulation reaches twice the full scale, whatever a user asks for.
  const double least = std::min(least_modulation(settings, full_scale), 2 * full_scale);
  SinusoidLimits limits{.mean_scale = static_cast<float>(mean_of / stage.steps)};
  if (const ClosedForm* form = closed_form(stage.steps)) {
    // The least integer whose root passes in double, so that the same pixels do.
    double square = std::max(std::floor(least * form->divisor * least * form->divisor) - 2, 0.0);
    while (std::sqrt(square) / form->divisor < least) ++square;
    limits.least_square = static_cast<float>(square);
  } else {
    const double in_sums = least / stage.modulation_scale;
    limits.least_square = static_cast<float>(in_sums * in_sums);
  }
  if (settings.drop_saturated) limits.full_scale = static_cast<std::int32_t>(full_scale);
  return limits;
}

CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale) {
  const double grey_level = full_scale / 255;
  const double dimmest = stages.cue->dimmest_lit * grey_level / stages.sinusoid.modulation_scale;
  const double voting =
      least_neighbour_modulation(settings, full_scale) / stages.sinusoid.modulation_scale;
  return {.ambient = static_cast<float>(stages.cue->ambient * grey_level),
          .lit_square = static_cast<float>(dimmest * dimmest),
          .voting_square = static_cast<float>(voting * voting)};
}

}  // namespace slipstream
