#include "reconstruct/fused/cue_stage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/numbers.h"
#include "decode/cue_evidence.h"
#include "reconstruct/fused/coordinate_stage.h"
#include "reconstruct/fused/cue_rows.h"
#include "reconstruct/fused/narrow.h"
#include "reconstruct/fused/vote_rows.h"

namespace slipstream {
namespace {

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

}  // namespace

bool has_fused_cue(const EngineSetup& setup) {
  constexpr double most_periods = 16384;  // shifts in periods are stored in 16 bits
  const Layout& layout = setup.sequence.strategy.layout();

  return setup.settings.cue_rule == CueRule::consensus &&
         layout.bands.front().periods <= most_periods && cue_kind(layout);
}

FusedStages::Cue fused_cue(const Layout& layout, const EngineSetup& setup) {
  const CueEvidence exact(layout, cue_settings(setup));

  return {.stage = cue_stage(layout, setup),
          .exact = exact,
          .f_h = layout.bands[0].periods,
          .projector_length = projector_length(setup),
          .costs = order_cost_stage(layout, exact, exact.margin(projector_length(setup)))};
}

}  // namespace slipstream
