#include "reconstruct/fused/fused_stages.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
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
#include "reconstruct/fused/coordinate_stage.h"
#include "reconstruct/fused/cue_stage.h"
#include "reconstruct/fused/narrow.h"
#include "reconstruct/fused/order_rows.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/point_stage.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/vote_rows.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

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

  const int pixels = projector_length(setup), shown = 1 << code.frames.size();
  bits.stage.pixels = static_cast<float>(pixels);
  for (int stripe = 0; stripe <= shown; ++stripe) {
    bits.stage.first_pixels.push_back(first_pixel(code, stripe, pixels));
  }

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

/// Why the stripe geometry cannot be computed.
std::string why_no_geometry(const Lens& projector) {
  if (!projector.residual.terms.empty()) {
    return "the projector's lens bends too much for its residual map";
  }
  return "the projector's lens model cannot be inverted over its picture";
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
    if (!geometry) why = why_no_geometry(scanner.projector);
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
