#include "reconstruct/fused/fused_stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "base/numbers.h"
#include "decode/cue_evidence.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "geometry/ray_blocks.h"
#include "geometry/ray_table.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/band_stage.h"
#include "reconstruct/fused/cue_rows.h"
#include "reconstruct/fused/order_rows.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/vote_rows.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

float narrow(double value) {
  return static_cast<float>(value);
}

/// Stage of a band of `frequency` periods whose coordinate is known up to 1 / `widest`.
CoordinateStage coordinate_stage(double frequency, double widest, int projector_length) {
  const double period = 1 / widest;

  // The field begins half a pixel before the first pixel's centre. A longer period reaches as
  // far past one end of the field as past the other.
  return placing(narrow(1 / frequency), narrow(period),
                 narrow(-0.5 / projector_length - (period - 1) / 2));
}

/// Stage that does not move coordinates into the field.
CoordinateStage unplaced(double periods) {
  // No coordinate leaves this long period.
  return placing(narrow(1 / periods), 1e9F, -5e8F);
}

FusedStages::CodeBits code_bits(const Layout& layout, const EngineSetup& setup) {
  const Code& code = *layout.code;
  const CodeNumbers numbers{.gray = code.gray ? 1 : 0, .stripe = narrow(1 / code.stripes)};
  FusedStages::CodeBits bits{.stage = {numbers, code.frames, code.inverses},
                             .against_mean = code.reference == measuring_band(layout).mean,
                             .reference = {}};

  // The masks of the base bit and of the bits it inverts. The first frame is the highest bit.
  if (code.base) {
    const int count = static_cast<int>(code.frames.size());
    bits.stage.base = 1 << (count - 1 - *code.base);
    bits.stage.others = ((1 << count) - 1) & ~bits.stage.base;
  }

  for (const double weight : code.reference) bits.reference.push_back(narrow(weight));
  if (!layout.unwrapping->whole_stripes) return bits;

  // A code alone also reports which bits are doubtful (within three standard deviations of the
  // noise), and the contrast over all frames, so it needs the frames that are not bits too.
  bits.against_mean = false;
  bits.stage.alone = true;
  bits.stage.tolerance = narrow(3 * std::sqrt(cue_settings(setup).noise_variance));
  bits.stage.least_contrast = narrow(setup.settings.minimum_modulation);
  for (int n = 0; n < layout.frames; ++n) {
    if (std::ranges::count(code.frames, n) == 0) bits.stage.rest.push_back(n);
  }

  // The error of the rounded stripe width, which a high stripe number multiplies.
  bits.stage.narrower = narrow(numbers.stripe - 1 / code.stripes);
  bits.stage.shift = narrow(-0.5 / projector_length(setup));
  bits.stage.largest_doubt = narrow(setup.settings.fringe_order.largest_doubt);

  return bits;
}

/// Stage that tries the orders of the measuring band against all bands, or all single frames.
OrderStage order_stage(const Layout& layout, const EngineSetup& setup) {
  const double f = measuring_band(layout).periods, begin = -0.5 * f / projector_length(setup);

  OrderStage stage{.period = narrow(1 / f),
                   .begin = narrow(begin),
                   .end = narrow(begin + f),
                   .orders = static_cast<int>(f) + 2,
                   .largest_doubt = narrow(setup.settings.fringe_order.largest_doubt)};

  // Against whole bands: the caller adds the waves.
  if (layout.single_frames.empty()) return stage;

  // Against single frames: a wave for each frame, and its phase at the start of each order.
  const std::vector<SingleFrame> frames = frames_of_sinusoids(layout);
  stage.steps = frames.size() - layout.single_frames.size();

  for (const auto& [frame, periods, origin] : frames) {
    stage.waves.push_back(
        {.ratio = narrow(periods / f), .shift = narrow(-origin / two_pi), .frame = frame});
  }

  for (int k = -1; k < stage.orders - 1; ++k) {
    for (const SingleFrame& shown : frames) {
      const double angle = two_pi * k * shown.periods / f + shown.origin;
      stage.beginnings.push_back({narrow(std::cos(angle)), narrow(std::sin(angle))});
    }
  }

  return stage;
}

/// `periods`: of the coordinate that it gives.
FusedStages::Link link(std::vector<int> of, double ratio, double periods,
                       const EngineSetup& setup) {
  const double largest_doubt = setup.settings.fringe_order.largest_doubt;
  return {.of = std::move(of),
          .unwrap = {.ratio = narrow(ratio),
                     .largest_doubt = narrow(largest_doubt),
                     .coordinate = unplaced(periods)}};
}

/// The sinusoids of all bands, each with the index of its band.
using Sinusoids = std::vector<std::pair<std::size_t, const Band*>>;

/// In the order of the stages: the measuring band, the other bands, then the mirrored ones.
Sinusoids ordered_sinusoids(const Layout& layout) {
  const std::size_t measuring = measuring_band_index(layout);

  Sinusoids sinusoids;
  for (std::size_t i = 0; i < layout.bands.size(); ++i) sinusoids.emplace_back(i, &layout.bands[i]);
  std::rotate(sinusoids.begin(), sinusoids.begin() + measuring, sinusoids.begin() + measuring + 1);

  for (std::size_t i = 0; i < layout.bands.size(); ++i) {
    for (const Band& mirrored : layout.bands[i].mirrored) sinusoids.emplace_back(i, &mirrored);
  }

  return sinusoids;
}

/// The factor of each sinusoid in a sum. A mirrored sinusoid has the factor of its band.
std::vector<int> factors(const PhaseSum& sum, const Sinusoids& sinusoids) {
  std::vector<int> of;
  for (const auto& [i, band] : sinusoids) of.push_back(sum.of[i]);
  return of;
}

/// Tries every fringe order.
void try_orders(FusedStages& stages, const Sinusoids& sinusoids, const Layout& layout,
                const EngineSetup& setup) {
  stages.orders = order_stage(layout, setup);
  if (!stages.weighs_modulations()) return;

  // A wave per sinusoid, weighted by the inverse variance of its phase.
  for (const auto& [i, band] : sinusoids) {
    stages.orders->waves.push_back({.ratio = narrow(band->periods / measuring_band(layout).periods),
                                    .weight = narrow(1 / component_noise(*band))});
  }

  stages.coarse_in_field = true;  // the mean of all bands may leave it
}

/// Takes the fringe order from a code's stripes. `periods`: of the measured phase.
void take_order_from_code(FusedStages& stages, double periods, const Layout& layout,
                          const EngineSetup& setup) {
  stages.code = code_bits(layout, setup);
  if (layout.unwrapping->whole_stripes) {
    stages.consensus.fewest_neighbours = 0;  // only doubtful pixels need them, as in `judged`
    return;
  }

  // A phase anywhere within its stripe leaves no doubt, so only the rest of the residual counts.
  const double open = open_by_code(*layout.code, periods);
  stages.chain.push_back(link(stages.measured, periods, periods, setup));
  UnwrapStage& unwrap = stages.chain.back().unwrap;
  unwrap.open = narrow(open);
  unwrap.doubt_scale = narrow(1 / (1 - 2 * open));
}

/// Unwraps band after band, from the coarsest to the measuring one.
void unwrap_in_chain(FusedStages& stages, const std::vector<PhaseSum>& chain,
                     const Sinusoids& sinusoids, const Layout& layout, const EngineSetup& setup) {
  // A single band needs this only if its mirrored sinusoids must be added up.
  const bool several = chain.size() > 1;
  if (!several && measuring_band(layout).mirrored.empty()) return;
  stages.only_adds = !several;
  if (!several) stages.consensus.fewest_neighbours = 0;

  stages.coarse = factors(chain.front(), sinusoids);
  stages.coarse_in_field = !is_circle(layout);
  stages.coarse_stage =
      coordinate_stage(chain.front().periods, chain.front().periods, projector_length(setup));

  // One link per member after the first. The first link starts from fields, not turns, if the
  // coarse coordinate has already been placed in the field.
  for (std::size_t i = several ? 1 : 0; i < chain.size(); ++i) {
    const bool first = i == 1 && stages.coarse_in_field;
    const double before = first ? 1 : chain[i - (several ? 1 : 0)].periods;
    stages.chain.push_back(link(factors(chain[i], sinusoids), chain[i].periods / before, 1, setup));
  }

  // A circular chain places its result in the field at the end; a weighted mean does so itself.
  UnwrapStage& last = stages.chain.back().unwrap;
  const bool places = !stages.coarse_in_field && !stages.weighs_bands;
  last.coordinate = places ? stages.coordinate : unplaced(chain.back().periods);
}

/// Adds the bands, the measuring one first, and their unwrapping.
void add_bands(FusedStages& stages, const Layout& layout, const EngineSetup& setup,
               const PhaseCorrections& corrections) {
  const std::vector<double> weights = band_weights(layout);
  const Sinusoids sinusoids = ordered_sinusoids(layout);
  for (const auto& [i, band] : sinusoids) {
    stages.bands.push_back(band_stage(*band, corrections));
    stages.bands.back().weight = narrow(weights[i]);
  }

  stages.weighs_bands = weights[measuring_band_index(layout)] < 1;

  // The fringe order: by trial, from a code, or along a chain of bands.
  if (layout.unwrapping->tries_orders) return try_orders(stages, sinusoids, layout, setup);

  const std::vector<PhaseSum> chain = unwrapping_chain(layout);
  stages.measured = factors(chain.back(), sinusoids);

  if (layout.unwrapping->reads_code) {
    return take_order_from_code(stages, chain.back().periods, layout, setup);
  }

  unwrap_in_chain(stages, chain, sinusoids, layout, setup);
}

/// Adds the measuring band, whose fringe order is known from the coarse coordinate.
void add_known_band(FusedStages& stages, const EngineSetup& setup,
                    const PhaseCorrections& corrections) {
  const Band& band = measuring_band(setup.sequence.strategy.layout());
  stages.bands.push_back(band_stage(band, corrections));
  stages.measured = {1};
  stages.coarse_given = true;
  stages.chain.push_back(link({1}, band.periods, band.periods, setup));

  // Each pixel's order comes from outside, so neighbours need not confirm it.
  if (unwraps_by_depth(setup)) stages.consensus.fewest_neighbours = 0;
}

/// How the kernels find a cue in the frames.
struct CueKind {
  CueForm form = CueForm::circle;
  CueStage::Sums sums = CueStage::Sums::any;
};

/// Whether the kernels have sums of their own for these weights of a cue in N frames.
bool is_closed(int steps, CueForm form, const std::vector<double>& weights) {
  const auto are = [&](const std::vector<double>& others) {
    constexpr double rounding = 1e-9;
    return std::ranges::equal(weights, others,
                              [](double a, double b) { return std::abs(a - b) < rounding; });
  };

  if (steps == 3) return form == CueForm::linear && are(mean_weights(3));
  if (steps == 4) return are(half_phase_weights());
  return steps == 6 && form == CueForm::linear && are(phase_shifted_band(6, 0, 6, 1, 2).cosine);
}

/// nullopt if they cannot.
std::optional<CueKind> cue_kind(const Layout& layout) {
  using enum CueStage::Sums;
  const Band& high = layout.bands.front();

  CueKind kind;

  // A real cue: its reference must be one that the kernels can invert.
  if (layout.cue) {
    const CueReference::Form form = layout.cue->reference.form();
    if (form == CueReference::Form::other) return std::nullopt;
    kind.form = form == CueReference::Form::cosine ? CueForm::cosine : CueForm::linear;
  }

  if (high.cycle) return kind;  // a window has weights

  // Otherwise all frames must be one run of steps, with integer sums where they exist.
  const std::optional<StepRun> run = step_run(high);
  if (!run || run->first != 0 || run->steps != layout.frames) return std::nullopt;

  const int N = run->steps;
  if (layout.cue && is_closed(N, kind.form, layout.cue->weights)) kind.sums = closed;
  if (!layout.cue) {
    if (run->shifts != Shifts{}) return std::nullopt;  // they would also turn the second channel
    if (N >= 5 && is_channel(layout.bands[1], *run, 2)) kind.sums = N > 6 ? mirrored : closed;
  }

  return N > 6 || kind.sums == closed ? std::optional(kind) : std::nullopt;
}

bool has_fused_cue(const EngineSetup& setup) {
  constexpr double most_periods = 16384;  // shifts in periods are stored in 16 bits
  const Layout& layout = setup.sequence.strategy.layout();

  return setup.settings.cue_rule == CueRule::consensus &&
         layout.bands.front().periods <= most_periods && cue_kind(layout);
}

/// Why the row kernels cannot be used; an empty string if they can.
std::string why_not_in_rows(const EngineSetup& setup) {
  constexpr double widest_margin = 0.25;
  const Strategy& strategy = setup.sequence.strategy;
  const Layout& layout = strategy.layout();

  // Two sinusoids of a band are added up in a chain alone.
  const bool adds = carrier_periods(layout) > 0;
  if (layout.unwrapping->pixel != nullptr ||
      (adds && (order_source(layout) != OrderSource::bands || unwraps_by_picture(setup)))) {
    return fmt::format("it does not support {}", strategy.name());
  }

  const auto waves = layout.single_frames.empty() ? std::ssize(layout.bands) : layout.frames;
  if (layout.unwrapping->tries_orders && waves > OrderStage::most_waves) {
    return fmt::format("it compares at most {} sinusoids", OrderStage::most_waves);
  }

  // The fringe order must come from somewhere that the kernels know.
  if (!has_coordinate(layout) && !unwraps_by_depth(setup)) return "it requires a coordinate";
  if (order_source(layout) == OrderSource::neighbours && !has_fused_cue(setup)) {
    return fmt::format("it does not support these cue settings of {}", strategy.name());
  }

  // The polynomials cover a limited margin, and a row must fill a vector.
  if (setup.settings.field_margin > widest_margin) {
    return fmt::format("the field margin is above {}", widest_margin);
  }
  if (setup.scanner.camera.size.width >= least_row_width) return {};
  return fmt::format("the image is narrower than {} pixels", least_row_width);
}

CueStage cue_stage(const Layout& layout, const EngineSetup& setup) {
  const CueKind kind = *cue_kind(layout);
  const CueSettings settings = cue_settings(setup);
  const auto& [alpha_p, beta_p] = settings.light;
  const double f_h = layout.bands[0].periods, c1 = layout.bands[0].share;
  const double c2 = layout.cue ? layout.cue->share : layout.bands[1].share;

  // A cue in the mean also contains the projector's offset and the ambient light.
  const bool is_in_mean = needs_ambient_light(layout);
  const double dc = is_in_mean ? 1 + 2 * (beta_p + settings.ambient) / alpha_p : 0;

  CueStage stage{CueNumbers{.gain = narrow(c1 / c2),
                            .offset = narrow(dc / c2),
                            .shade = is_in_mean ? narrow(c2 / c1) : 0,
                            .periods = narrow(f_h),
                            .largest_doubt = narrow(setup.settings.fringe_order.largest_doubt)},
                 kind.form, kind.sums};
  stage.coordinate = coordinate_stage(f_h, 1, projector_length(setup));

  // Weights of the cue's channel, or the scale of its integer sums. These hold C and S up to a
  // factor: S / C is 2 sin(2 pi / 5) V / U for N = 5 and sqrt(3) V / U for N = 6.
  if (kind.sums != CueStage::Sums::closed) {
    stage.cosines = layout.cue ? layout.cue->weights : layout.bands[1].cosine;
    stage.sines = layout.cue ? std::vector<double>(stage.cosines.size()) : layout.bands[1].sine;
  } else if (kind.form != CueForm::circle) {
    stage.channel_scale = 1.0F / static_cast<float>(layout.frames);
  } else {
    stage.sine_weight = narrow(layout.frames == 5 ? 2 * std::sin(two_pi / 5) : std::sqrt(3));
  }

  return stage;
}

OrderCostStage order_cost_stage(const Layout& layout, const CueEvidence& exact, double margin) {
  const CueCost& cost = exact.cost();
  const bool is_cosine = cost.reference.form() == CueReference::Form::cosine;
  const Band& high = layout.bands[0];

  return {OrderCostNumbers{.form = cost.circle ? CueForm::circle
                                   : is_cosine ? CueForm::cosine
                                               : CueForm::linear,
                           .share = narrow(cost.c1),
                           .cue_share = narrow(cost.c2),
                           .constant_light = narrow(cost.constant_light),
                           .steady = narrow(cost.steady),
                           .component_variance = narrow(cost.component_variance),
                           .cue_variance = narrow(cost.cue_variance),
                           .periods = narrow(high.periods),
                           .margin = narrow(margin)},
          high.cosine, high.sine,  //
          layout.cue ? layout.cue->weights : layout.bands[1].cosine,
          layout.cue ? std::vector<double>(high.sine.size()) : layout.bands[1].sine};
}

FusedStages::Cue fused_cue(const Layout& layout, const EngineSetup& setup) {
  const CueEvidence exact(layout, cue_settings(setup));

  return {.stage = cue_stage(layout, setup),
          .exact = exact,
          .f_h = layout.bands[0].periods,
          .projector_length = projector_length(setup),
          .costs = order_cost_stage(layout, exact, exact.margin(projector_length(setup)))};
}

std::vector<float> kernel_order(const PlanePolynomial& polynomial, int degree) {
  std::vector<float> coefficients;

  // The kernel's degree may be higher than the polynomial's: its other terms are 0.
  auto c = polynomial.coefficients.begin();
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      coefficients.push_back(i + j <= polynomial.degree ? narrow(*c++) : 0);
    }
  }

  std::reverse(coefficients.begin(), coefficients.end());
  return coefficients;
}

template <class Row>
RayTerms linear(const Row& row) {
  return {narrow(row(0)), narrow(row(1)), narrow(row(2))};
}

EdgeTerms edge(const std::array<double, StripeGeometry::edge_terms>& terms) {
  EdgeTerms all{};
  std::transform(terms.begin(), terms.end(), all.begin(), narrow);
  return all;
}

PointStage point_stage(const StripeGeometry& geometry, const DepthRange& depths) {
  // The kernels exist for odd degrees from 3 on, for no lens (0) and for Newton's method (-1).
  const int needed = geometry.solved ? -1 : geometry.lens.degree;
  const int degree = needed < 1 ? needed : std::max(3, needed | 1);  // odd ones are compiled

  const auto [inner_low, inner_high] = geometry.inner_places();
  constexpr double largest = std::numeric_limits<float>::max();

  return {PointNumbers{.coordinate = linear(geometry.coordinate),
                       .depth = linear(geometry.depth),
                       .facing = linear(geometry.facing),
                       .place_constant = linear(geometry.place_constant),
                       .place_slope = linear(geometry.place_slope),
                       .coordinate_offset = narrow(geometry.coordinate(3)),
                       .depth_offset = narrow(geometry.depth(3)),
                       .unit_scale = narrow(geometry.unit_coordinate.scale),
                       .unit_offset = narrow(geometry.unit_coordinate.offset),
                       .least_coordinate = narrow(geometry.least_coordinate),
                       .largest_coordinate = narrow(geometry.largest_coordinate),
                       .lens_degree = degree,
                       .low_edge = edge(geometry.low_edge),
                       .high_edge = edge(geometry.high_edge),
                       .inner_low = narrow(inner_low),
                       .inner_high = narrow(inner_high),
                       .nearest = narrow(std::min(depths.nearest, largest)),
                       .farthest = narrow(std::min(depths.farthest, largest))},
          kernel_order(geometry.lens, geometry.solved ? SolvedLens::start_degree : degree),
          geometry.solved, depths.nearest > 0 || depths.farthest < largest};
}

/// Limits blocks to turns before the cut, where the row kernel needs no cut.
void keep_before_cut(FusedStages& stages) {
  if (!stages.blocks) return;

  const CoordinateStage& circle = stages.coordinate;
  const auto unit = [&](float y) { return y * stages.point.unit_scale + stages.point.unit_offset; };

  // Above the rounding of p, so that no turn within the range lies past the cut.
  constexpr float apart = 1e-6F;

  for (RayBlocks::Range& range : stages.blocks->described) {
    range.least = std::max(range.least, unit(circle.cut) + apart);
    range.largest = std::min(range.largest, unit(circle.cut + circle.period) - apart);
  }
}

}  // namespace

std::optional<FusedStages> fused_stages(const EngineSetup& setup,
                                        const PhaseCorrections& corrections, std::string* why_not) {
  const auto& [scanner, sequence, settings] = setup;
  const Layout& layout = sequence.strategy.layout();
  const bool votes = order_source(layout) == OrderSource::neighbours;

  // 1. Find out whether the kernels can take this setup.
  std::optional<StripeGeometry> geometry;
  std::optional<RayTable> rays;

  std::string why = why_not_in_rows(setup);
  if (why.empty()) {
    geometry = stripe_geometry(scanner, sequence.axis, settings.field_margin);
    rays = ray_table(scanner.camera);
    if (!geometry) why = "the projector's lens model cannot be inverted over its picture";
    if (!rays) why = "the camera's lens model cannot be inverted over its picture";
  }

  if (!why.empty()) {
    if (why_not != nullptr) *why_not = why;
    return std::nullopt;
  }

  // 2. What every layout needs: the consensus, the field and the geometry. Neighbours agree if
  // their coordinates differ by less than half a period.
  std::optional<RayBlocks> blocks = ray_blocks(*geometry, *rays);

  const double f = measuring_band(layout).periods, widest = least_periods(layout);

  FusedStages stages{.frames = layout.frames,
                     .consensus = {narrow(0.5 / f), settings.fringe_order.fewest_neighbours,
                                   settings.fringe_order.fewest_if_doubtful},
                     .coordinate = coordinate_stage(f, widest, projector_length(setup)),
                     .point = point_stage(*geometry, depth_range(setup)),
                     .rays = std::move(*rays),
                     .blocks = std::move(blocks)};

  // 3. The bands, with the source of their fringe order.
  if (votes) {
    stages.bands.push_back(band_stage(layout.bands.front(), corrections));
    stages.cue = fused_cue(layout, setup);
  } else if (unwraps_by_picture(setup)) {
    add_known_band(stages, setup, corrections);
  } else {
    add_bands(stages, layout, setup, corrections);
    if (!stages.asks_neighbours()) keep_before_cut(stages);
  }

  // A code can name more stripes than are projected, and a fit end past the field.
  stages.point.may_leave_field = widest < 1 || stages.code || stages.orders ? 1 : 0;

  return stages;
}

SinusoidLimits sinusoid_limits(const SinusoidStage& stage, const ReconstructSettings& settings,
                               double full_scale, double saturation, double mean_of) {
  // No modulation reaches twice the full scale, whatever the setting.
  const double least = std::min(least_modulation(settings, full_scale), 2 * full_scale);

  SinusoidLimits limits{.mean_scale = narrow(mean_of / stage.steps)};

  const ClosedForm* form = stage.cosines.empty() ? closed_form(stage.steps) : nullptr;
  if (form != nullptr) {
    // The least integer whose root passes in double, so that the same pixels pass.
    double square = std::max(std::floor(least * form->divisor * least * form->divisor) - 2, 0.0);
    while (std::sqrt(square) / form->divisor < least) ++square;
    limits.least_square = narrow(square);
  } else {
    const double in_sums = least / stage.modulation_scale;
    limits.least_square = narrow(in_sums * in_sums);
  }

  if (settings.drop_saturated) limits.full_scale = static_cast<std::int32_t>(saturation);

  return limits;
}

CueLimits cue_limits(const FusedStages& stages, const ReconstructSettings& settings,
                     double full_scale) {
  const double grey_level = full_scale / 255;
  const CueEvidence& cue = stages.cue->exact;
  const float scale = stages.bands.front().sinusoid.modulation_scale;

  // The kernels compare U^2 + sine_square V^2, so the limits become squares in units of the sums.
  const double dimmest = cue.dimmest_lit() * grey_level / scale;
  const double voting = least_neighbour_modulation(settings, full_scale) / scale;

  return {.ambient = narrow(cue.cost().constant_light * grey_level),
          .lit_square = narrow(dimmest * dimmest),
          .voting_square = narrow(voting * voting)};
}

}  // namespace slipstream
