#include "slipstream/reconstruct/fused/fused_stages.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "slipstream/codes/unwrapping.h"
#include "slipstream/geometry/stripe_geometry.h"

namespace slipstream {
namespace {

/// `frequency` measures, `widest` says within which period.
CoordinateStage coordinate_stage(double frequency, double widest, int projector_length) {
  const double period = 1 / widest;
  return {.scale = static_cast<float>(1 / frequency),
          .period = static_cast<float>(period),
          .cut = static_cast<float>(-0.5 / projector_length - (period - 1) / 2)};
}

ConsensusStage consensus_stage(double frequency, const FringeOrderConsensus& settings) {
  return {.half_fringe = static_cast<float>(0.5 / frequency),
          .fewest_neighbours = settings.fewest_neighbours,
          .fewest_if_doubtful = settings.fewest_if_doubtful};
}

/// A coordinate wherever it lies, of so many periods in a unit.
CoordinateStage unplaced(double periods) {
  return {.scale = static_cast<float>(1 / periods), .period = 1e9F, .cut = -5e8F};
}

FusedStages::CodeBits code_bits(const Layout& layout) {
  const Code& code = *layout.code;
  FusedStages::CodeBits bits{.stage = {.frames = code.frames,
                                       .inverses = code.inverses,
                                       .gray = code.gray,
                                       .stripe = static_cast<float>(1 / code.stripes)},
                             .against_mean = code.reference == layout.bands.front().mean,
                             .reference = {}};
  if (code.base) {
    const int count = static_cast<int>(code.frames.size());
    bits.stage.base = 1 << (count - 1 - *code.base);
    bits.stage.others = ((1 << count) - 1) & ~bits.stage.base;
  }
  for (const double weight : code.reference) {
    bits.reference.push_back(static_cast<float>(weight));
  }
  return bits;
}

/// The bands, the measuring one first, and how they are unwrapped.
void add_bands(FusedStages& stages, const Layout& layout, const EngineSetup& setup,
               const PhaseCorrections& corrections) {
  const std::vector<double> weights = band_weights(layout);
  const auto measuring = static_cast<std::ptrdiff_t>(measuring_band_index(layout));
  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    stages.bands.push_back(band_stage(layout.bands[i], corrections));
    stages.bands.back().weight = static_cast<float>(weights[i]);
  }
  std::rotate(stages.bands.begin(), stages.bands.begin() + measuring,
              stages.bands.begin() + measuring + 1);
  const auto factors = [&](std::vector<int> of) {
    std::rotate(of.begin(), of.begin() + measuring, of.begin() + measuring + 1);
    return of;
  };
  stages.weighs_bands = weights[static_cast<std::size_t>(measuring)] < 1;
  const std::vector<PhaseSum> chain = unwrapping_chain(layout);
  const double largest_doubt = setup.settings.fringe_order.largest_doubt;
  const auto link = [&](const PhaseSum& fine, double ratio) {
    return FusedStages::Link{.of = factors(fine.of),
                             .unwrap = {.ratio = static_cast<float>(ratio),
                                        .largest_doubt = static_cast<float>(largest_doubt),
                                        .coordinate = unplaced(1)}};
  };
  if (way_of(layout.unwrapping).reads_code) {
    stages.code = code_bits(layout);
    stages.chain.push_back(link(chain.back(), chain.back().periods));
    UnwrapStage& unwrap = stages.chain.back().unwrap;
    unwrap.coordinate = unplaced(chain.back().periods);
    const double open = open_by_code(*layout.code, chain.back().periods);
    unwrap.open = static_cast<float>(open);
    unwrap.doubt_scale = static_cast<float>(1 / (1 - 2 * open));
    return;
  }
  if (chain.size() < 2) return;
  stages.coarse = factors(chain.front().of);
  stages.coarse_in_field = !is_circle(layout);
  stages.coarse_stage =
      coordinate_stage(chain.front().periods, chain.front().periods, projector_length(setup));
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const bool first = i == 1 && stages.coarse_in_field;
    stages.chain.push_back(
        link(chain[i], first ? chain[i].periods : chain[i].periods / chain[i - 1].periods));
  }
  UnwrapStage& last = stages.chain.back().unwrap;
  const bool places = !stages.coarse_in_field && !stages.weighs_bands;
  last.coordinate = places ? stages.coordinate : unplaced(chain.back().periods);
}

/// The measuring band, whose coordinate is known but for rounding.
void add_known_band(FusedStages& stages, const EngineSetup& setup,
                    const PhaseCorrections& corrections) {
  const Band& band = measuring_band(setup.sequence.strategy.layout());
  stages.bands.push_back(band_stage(band, corrections));
  stages.coarse_given = true;
  stages.chain.push_back(
      {.of = {1},
       .unwrap = {.ratio = static_cast<float>(band.periods),
                  .largest_doubt = static_cast<float>(setup.settings.fringe_order.largest_doubt),
                  .coordinate = unplaced(band.periods)}});
  if (unwraps_by_depth(setup)) stages.consensus.fewest_neighbours = 0;
}

/// N of the frames in whose channels the kernels find a cue; none for others.
std::optional<int> cue_steps(const Layout& layout) {
  const auto run = step_run(layout.bands.front());
  if (!run || run->first != 0 || run->steps != layout.frames || run->shifts != Shifts{}) {
    return std::nullopt;
  }
  const int N = run->steps;
  if (!layout.cue) {
    const bool second = N >= 5 && is_channel(layout.bands[1], {0, N}, 2);
    return second ? std::optional(N) : std::nullopt;
  }
  const auto is_published = [&](int steps, const std::vector<double>& weights,
                                CueReference::Form form) {
    return N == steps && layout.cue->weights == weights && layout.cue->reference.form() == form;
  };
  const bool known = is_published(3, mean_weights(3), CueReference::Form::linear) ||
                     is_published(4, half_phase_weights(), CueReference::Form::cosine);
  return known ? std::optional(N) : std::nullopt;
}

bool has_fused_cue(const EngineSetup& setup) {
  constexpr double most_periods = 16384;  // shifts of whole periods are kept in 16 bits
  const Layout& layout = setup.sequence.strategy.layout();
  return setup.settings.cue_rule == CueRule::consensus &&
         layout.bands.front().periods <= most_periods && cue_steps(layout);
}

CueStage cue_stage(const Layout& layout, const EngineSetup& setup) {
  const int N = layout.frames;
  const CueSettings settings = cue_settings(setup);
  const auto& [alpha_p, beta_p] = settings.light;
  const double f_h = layout.bands[0].periods, c1 = layout.bands[0].share;
  const double c2 = layout.cue ? layout.cue->share : layout.bands[1].share;
  const double dc = needs_ambient_light(layout) ? 1 + 2 * (beta_p + settings.ambient) / alpha_p : 0;
  CueStage stage{.gain = static_cast<float>(c1 / c2),
                 .offset = static_cast<float>(dc / c2),
                 .shade = static_cast<float>(c2 / c1),
                 .periods = static_cast<float>(f_h),
                 .largest_doubt = static_cast<float>(setup.settings.fringe_order.largest_doubt),
                 .coordinate = coordinate_stage(f_h, 1, projector_length(setup))};
  if (N == 5) {
    stage.sine_weight = static_cast<float>(2 * std::sin(2 * std::numbers::pi / 5));
  } else if (N == 6) {
    stage.sine_weight = static_cast<float>(std::sqrt(3));
  } else if (N > 6) {
    stage.cosines = layout.bands[1].cosine;
    stage.sines = layout.bands[1].sine;
  }
  return stage;
}

OrderCostStage order_cost_stage(const Layout& layout, const CueEvidence& exact, double margin) {
  const CueCost& cost = exact.cost();
  const bool is_cosine = cost.reference.form() == CueReference::Form::cosine;
  const auto reference = is_cosine ? OrderCostStage::Cue::cosine : OrderCostStage::Cue::linear;
  const Band& high = layout.bands[0];
  return {.cosines = high.cosine,
          .sines = high.sine,
          .cue = layout.cue ? layout.cue->weights : layout.bands[1].cosine,
          .cue_sine = layout.cue ? std::vector<double>(high.sine.size()) : layout.bands[1].sine,
          .form = cost.circle ? OrderCostStage::Cue::circle : reference,
          .share = static_cast<float>(cost.c1),
          .cue_share = static_cast<float>(cost.c2),
          .constant_light = static_cast<float>(cost.constant_light),
          .steady = static_cast<float>(cost.steady),
          .component_variance = static_cast<float>(cost.component_variance),
          .cue_variance = static_cast<float>(cost.cue_variance),
          .periods = static_cast<float>(high.periods),
          .margin = static_cast<float>(margin)};
}

FusedStages::Cue fused_cue(const Layout& layout, const EngineSetup& setup) {
  const CueSettings settings = cue_settings(setup);
  const CueEvidence exact(layout, settings);
  return {.stage = cue_stage(layout, setup),
          .exact = exact,
          .f_h = layout.bands[0].periods,
          .projector_length = projector_length(setup),
          .dimmest_lit = exact.dimmest_lit(),
          .ambient = needs_ambient_light(layout) ? settings.ambient : 0,
          .costs = order_cost_stage(layout, exact, exact.margin(projector_length(setup)))};
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

PointStage point_stage(const StripeGeometry& geometry, const DepthRange& depths) {
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
          .nearest = static_cast<float>(std::min(depths.nearest, largest)),
          .farthest = static_cast<float>(std::min(depths.farthest, largest)),
          .limits_depth = depths.nearest > 0 || depths.farthest < largest};
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

std::optional<FusedStages> fused_stages(const EngineSetup& setup,
                                        const PhaseCorrections& corrections) {
  constexpr double widest_margin = 0.25;
  const auto& [scanner, sequence, settings] = setup;
  const Layout& layout = sequence.strategy.layout();
  const bool votes = order_source(layout) == OrderSource::neighbours;
  const bool by_reference = !way_of(layout.unwrapping).in_kernels || carrier_periods(layout) > 0;
  if (by_reference || (votes && !has_fused_cue(setup)) || settings.field_margin > widest_margin ||
      scanner.camera.size.width < least_row_width) {
    return std::nullopt;
  }
  const auto geometry = stripe_geometry(scanner, sequence.axis, settings.field_margin);
  if (!geometry) return std::nullopt;
  std::optional<RayTable> rays = ray_table(scanner.camera);
  if (!rays) return std::nullopt;
  std::optional<RayBlocks> blocks = ray_blocks(*geometry, *rays);

  const double f = measuring_band(layout).periods, widest = least_periods(layout);
  FusedStages stages{.frames = layout.frames,
                     .bands = {},
                     .coarse = {},
                     .code = {},
                     .chain = {},
                     .cue = {},
                     .consensus = consensus_stage(f, settings.fringe_order),
                     .coordinate = coordinate_stage(f, widest, projector_length(setup)),
                     .point = point_stage(*geometry, depth_range(setup)),
                     .rays = std::move(*rays),
                     .blocks = std::move(blocks)};
  if (votes) {
    stages.bands.push_back(band_stage(layout.bands.front(), corrections));
    stages.cue = fused_cue(layout, setup);
  } else if (unwraps_by_picture(setup)) {
    add_known_band(stages, setup, corrections);
  } else {
    add_bands(stages, layout, setup, corrections);
    if (stages.chain.empty()) keep_before_cut(stages);
  }
  // Codes may be more than the stripes that are shown.
  stages.point.may_leave_field = widest < 1 || stages.code;
  return stages;
}

SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double saturation, double mean_of) {
  // No pixel's modulation reaches twice the full scale, whatever a user asks for.
  const double least = std::min(least_modulation(settings, full_scale), 2 * full_scale);
  SinusoidLimits limits{.mean_scale = static_cast<float>(mean_of / stage.steps)};
  const ClosedForm* form = stage.cosines.empty() ? closed_form(stage.steps) : nullptr;
  if (form != nullptr) {
    // The least integer whose root passes in double, so that the same pixels do.
    double square = std::max(std::floor(least * form->divisor * least * form->divisor) - 2, 0.0);
    while (std::sqrt(square) / form->divisor < least) ++square;
    limits.least_square = static_cast<float>(square);
  } else {
    const double in_sums = least / stage.modulation_scale;
    limits.least_square = static_cast<float>(in_sums * in_sums);
  }
  if (settings.drop_saturated) limits.full_scale = static_cast<std::int32_t>(saturation);
  return limits;
}

CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale) {
  const double grey_level = full_scale / 255;
  const double dimmest =
      stages.cue->dimmest_lit * grey_level / stages.bands.front().sinusoid.modulation_scale;
  const double voting = least_neighbour_modulation(settings, full_scale) /
                        stages.bands.front().sinusoid.modulation_scale;
  return {.ambient = static_cast<float>(stages.cue->ambient * grey_level),
          .lit_square = static_cast<float>(dimmest * dimmest),
          .voting_square = static_cast<float>(voting * voting)};
}

}  // namespace slipstream
