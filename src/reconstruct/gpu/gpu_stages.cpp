#include "reconstruct/gpu/gpu_stages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <vector>

#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/unwrap_rows.h"
#include "reconstruct/fused/vote_rows.h"

namespace slipstream {
namespace {

static_assert(std::is_trivially_copyable_v<GpuStages> && alignof(GpuStages) == sizeof(int));

/// Words that the stages index.
struct Words {
  [[nodiscard]] int place() const { return static_cast<int>(all.size()); }
  void add(int value) { all.push_back(value); }
  void add(float value) { all.push_back(std::bit_cast<int>(value)); }

  template <class Values>
  int add_all(const Values& values) {
    const int at = place();
    for (const auto value : values) add(value);
    return at;
  }

  std::vector<int> all{};
};

/// Weights as whole multiples of a unit: 1 if they are whole numbers, else 2^-30 of the largest.
struct WholeWeights {
  explicit WholeWeights(const std::vector<double>& weights) {
    constexpr double rounding = 1e-6;  // of factors stored as floats

    double largest = 0;
    bool whole = true;
    for (const double weight : weights) {
      largest = std::max(largest, std::abs(weight));
      whole = whole && std::abs(weight - std::round(weight)) < rounding;
    }

    constexpr double most_whole = 1000;
    if (!(whole && largest < most_whole) && largest > 0) unit = largest * 0x1p-30;

    for (const double weight : weights)
      values.push_back(static_cast<int>(std::lround(weight / unit)));
  }

  double unit = 1;
  std::vector<int> values;
};

/// a, b and c of GpuBand; b and c from -1024 to 1023.
void add_parts(int value, Words& words) {
  constexpr int radix = 2048;
  const auto low = [](int v) { return ((v + radix / 2) & (radix - 1)) - radix / 2; };
  const int c = low(value), rest = (value - c) / radix, b = low(rest);

  words.add((rest - b) / radix);
  words.add(b);
  words.add(c);
}

/// Weights of Eqs. (2.1) to (2.3) and of N = 5, which SinusoidStage does not store.
std::vector<double> closed_form_weights(const SinusoidStage& stage, bool sine) {
  std::vector<double> weights;
  const double N = stage.steps, scale = 2 / (N * stage.modulation_scale);

  for (int n = 0; n < stage.steps; ++n) {
    const double angle = 2 * std::numbers::pi * n / N;
    weights.push_back(sine ? scale * std::sin(angle) / stage.sine_weight : scale * std::cos(angle));
  }

  return weights;
}

GpuBand gpu_band(const FusedStages::BandStage& band, Words& words) {
  const SinusoidStage& stage = band.sinusoid;
  const bool closed = stage.cosines.empty();

  // The weights of the sums, as whole numbers.
  const WholeWeights cosine(closed ? closed_form_weights(stage, false) : stage.cosines);
  const WholeWeights sine(closed ? closed_form_weights(stage, true) : stage.sines);

  const int weights = words.place();
  for (std::size_t n = 0; n < cosine.values.size(); ++n) {
    add_parts(cosine.values[n], words);
    add_parts(sine.values[n], words);
    words.add(stage.means.empty() ? 1.0F : stage.means[n]);
  }

  // The corrections of the phase.
  const int wave = words.add_all(stage.correction_wave);
  const int table = words.add_all(stage.correction);

  // A turn of 1 uses the last entry, and reads one past it with weight 0.
  if (!stage.correction.empty()) words.add(stage.correction.back());

  return {.first_frame = band.first_frame,
          .frames = static_cast<int>(cosine.values.size()),
          .weights = weights,
          .whole = cosine.unit == 1 && sine.unit == 1 ? 1 : 0,
          .cosine_unit = static_cast<float>(cosine.unit),
          .sine_unit = static_cast<float>(sine.unit),
          .sinusoid = stage,
          .limits = {},
          .wave_terms = static_cast<int>(stage.correction_wave.size()),
          .wave = wave,
          .segments = static_cast<int>(stage.segments),
          .table = table,
          .periods = static_cast<float>(band.periods),
          .period = 1 / static_cast<float>(band.periods),
          .weight = band.weight};
}

GpuLink gpu_link(const std::vector<int>& of, const UnwrapStage& unwrap, Words& words) {
  // One band with the factor 1 and no other.
  const auto alone = std::find(of.begin(), of.end(), 1);
  const bool is_alone =
      alone != of.end() && std::count(of.begin(), of.end(), 0) + 1 == std::ssize(of);

  return {.factors = words.add_all(of),
          .alone = is_alone ? static_cast<int>(alone - of.begin()) : -1,
          .unwrap = unwrap};
}

GpuCode gpu_code(const FusedStages::CodeBits& bits, Words& words) {
  const CodeStage& stage = bits.stage;

  const int frames = words.add_all(stage.frames);
  const int inverses = stage.inverses.empty() ? -1 : words.add_all(stage.inverses);
  const int reference = words.place();
  words.add(static_cast<int>(bits.reference.size()));
  words.add_all(bits.reference);

  return {.bits = stage,
          .count = static_cast<int>(stage.frames.size()),
          .frames = frames,
          .inverses = inverses,
          .against_mean = bits.against_mean ? 1 : 0,
          .reference = reference,
          .mean_to_frames = 1};
}

GpuVote gpu_vote(const OrderCostStage& costs, Words& words) {
  const float c1 = costs.share, c2 = costs.cue_share;
  std::vector<int> lines(SurfaceWindow::line_cells.begin(), SurfaceWindow::line_cells.end());

  return {.period = 1 / costs.periods,
          .to_8_bits = 1,
          .shade = 0,
          .relative_share = c2 / c1,
          .relative_variance = costs.component_variance / costs.cue_variance,
          .circle_weight = 1 / ((c1 * c1 + c2 * c2) * costs.component_variance),
          .lines = words.add_all(lines)};
}

bool is_too_much(const FusedStages& stages) {
  const auto& code = stages.code;

  const bool is_compared =
      !code || code->against_mean || !code->reference.empty() || !code->stage.inverses.empty();

  return stages.orders || stages.reads_stripes() || !is_compared ||
         std::ranges::count(stages.measured, 1) > 1 || stages.point.solved ||
         std::max(stages.bands.size(), stages.chain.size()) > most_bands ||
         std::any_of(stages.bands.begin(), stages.bands.end(), [](const auto& band) {
           constexpr std::ptrdiff_t most_frames = 31;  // see GpuBand
           return std::max(std::ssize(band.sinusoid.cosines), std::ptrdiff_t{band.sinusoid.steps}) >
                  most_frames;
         });
}

}  // namespace

std::optional<GpuProgramText> gpu_stages(const FusedStages& stages) {
  if (is_too_much(stages)) return std::nullopt;

  // 1. Numbers of the whole picture.
  Words words;
  GpuStages out{};
  out.kept = stages.cue ? 8 : 2;

  out.width = stages.rays.E_x.width();
  out.height = stages.rays.E_x.height();

  out.links = static_cast<int>(stages.chain.size());
  out.begins_with_code = stages.code ? 1 : 0;
  out.coarse_in_field = stages.coarse_in_field ? 1 : 0;
  out.weighs_bands = stages.weighs_bands ? 1 : 0;

  out.coarse_stage = stages.coarse_stage;
  out.coordinate = stages.cue ? stages.cue->stage.coordinate : stages.coordinate;
  out.weighed = placing(1, out.coordinate.period, out.coordinate.cut);

  out.points = stages.point;
  out.consensus = stages.consensus;
  out.lens = words.add_all(stages.point.lens);
  out.confirmed = stages.chain.empty() && !stages.cue ? 0 : 1;

  // 2. The bands, and where their chain begins.
  if (!stages.coarse.empty()) out.coarse = gpu_link(stages.coarse, {}, words);
  if (stages.code) out.code = gpu_code(*stages.code, words);

  for (std::size_t i = 0; i < stages.bands.size(); ++i) {
    out.bands[i] = gpu_band(stages.bands[i], words);
  }

  // 3. A cue and its vote. The shaders sum the cue's channel as a second band.
  if (stages.cue) {
    out.cue = stages.cue->stage;
    out.cost = stages.cue->costs;
    out.vote = gpu_vote(stages.cue->costs, words);
    SinusoidStage channel;
    channel.cosines = stages.cue->costs.cue;
    channel.sines = stages.cue->costs.cue_sine;
    out.bands[1] = gpu_band({.sinusoid = channel}, words);
  }

  // 4. The links of the chain.
  for (std::size_t i = 0; i < stages.chain.size(); ++i) {
    out.chain[i] = gpu_link(stages.chain[i].of, stages.chain[i].unwrap, words);
  }

  return GpuProgramText{out, std::move(words.all)};
}

}  // namespace slipstream
