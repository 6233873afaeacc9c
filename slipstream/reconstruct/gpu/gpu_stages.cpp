#include "slipstream/reconstruct/gpu/gpu_stages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>

namespace slipstream {
namespace {

using Word = GpuStages::Word;

static_assert(std::is_trivially_copyable_v<GpuStages> && alignof(GpuStages) == sizeof(Word));

/// What stages point into, as it grows.
class Words {
 public:
  [[nodiscard]] Word place() const { return static_cast<Word>(all_.size()); }
  void add(Word value) { all_.push_back(value); }
  void add(float value) { all_.push_back(std::bit_cast<Word>(value)); }
  template <class Values>
  Word add_all(const Values& values) {
    const Word at = place();
    for (const auto value : values) add(value);
    return at;
  }
  std::vector<Word> take() { return std::move(all_); }

 private:
  std::vector<Word> all_;
};

/// Weights in wholes of a unit: themselves where they are whole numbers, else to 2^-30 of the
/// largest.
struct WholeWeights {
  explicit WholeWeights(const std::vector<double>& weights) {
    constexpr double rounding = 1e-6;  // of factors that are floats
    double largest = 0;
    bool whole = true;
    for (const double weight : weights) {
      largest = std::max(largest, std::abs(weight));
      whole = whole && std::abs(weight - std::round(weight)) < rounding;
    }
    constexpr double most_whole = 1000;
    if (!(whole && largest < most_whole) && largest > 0) unit = largest * 0x1p-30;
    for (const double weight : weights)
      values.push_back(static_cast<Word>(std::lround(weight / unit)));
  }

  double unit = 1;
  std::vector<Word> values;
};

/// a, b and c of GpuStages::Band; b and c from -1024 to 1023.
void add_parts(Word value, Words& words) {
  constexpr Word radix = 2048;
  const auto low = [](Word v) { return ((v + radix / 2) & (radix - 1)) - radix / 2; };
  const Word c = low(value), rest = (value - c) / radix, b = low(rest);
  words.add((rest - b) / radix);
  words.add(b);
  words.add(c);
}

/// The weights that Eqs. (2.1) to (2.3) and those of N = 5 stand for, which SinusoidStage leaves
/// out.
std::vector<double> closed_form_weights(const SinusoidStage& stage, bool sine) {
  std::vector<double> weights;
  const double N = stage.steps, scale = 2 / (N * stage.modulation_scale);
  for (int n = 0; n < stage.steps; ++n) {
    const double angle = 2 * std::numbers::pi * n / N;
    weights.push_back(sine ? scale * std::sin(angle) / stage.sine_weight : scale * std::cos(angle));
  }
  return weights;
}

GpuStages::Band gpu_band(const FusedStages::BandStage& band, Words& words) {
  const SinusoidStage& stage = band.sinusoid;
  const bool closed = stage.cosines.empty();
  const WholeWeights cosine(closed ? closed_form_weights(stage, false) : stage.cosines);
  const WholeWeights sine(closed ? closed_form_weights(stage, true) : stage.sines);
  GpuStages::Band out{.first_frame = band.first_frame,
                      .frames = static_cast<Word>(cosine.values.size()),
                      .weights = words.place(),
                      .whole = cosine.unit == 1 && sine.unit == 1 ? 1 : 0,
                      .cosine_unit = static_cast<float>(cosine.unit),
                      .sine_unit = static_cast<float>(sine.unit),
                      .sine_weight = stage.sine_weight,
                      .sine_square = stage.sine_square,
                      .modulation_scale = stage.modulation_scale,
                      .steps = stage.steps,
                      .direction = stage.direction,
                      .offset = stage.offset,
                      .periods = static_cast<float>(band.periods),
                      .period = 1 / static_cast<float>(band.periods),
                      .weight = band.weight};
  for (std::size_t n = 0; n < cosine.values.size(); ++n) {
    add_parts(cosine.values[n], words);
    add_parts(sine.values[n], words);
    words.add(stage.means.empty() ? 1.0F : stage.means[n]);
  }
  out.wave_terms = static_cast<Word>(stage.correction_wave.size());
  out.wave = words.add_all(stage.correction_wave);
  out.segments = static_cast<Word>(stage.segments);
  out.table = words.add_all(stage.correction);
  // A turn of 1 has the last entry, and reads one past it by nothing.
  if (out.segments > 0) words.add(stage.correction.back());
  return out;
}

GpuStages::Link gpu_link(const std::vector<int>& of, const UnwrapStage& unwrap, Words& words) {
  const auto alone = std::find(of.begin(), of.end(), 1);
  const bool is_alone =
      alone != of.end() && std::count(of.begin(), of.end(), 0) + 1 == std::ssize(of);
  return {.factors = words.add_all(of),
          .alone = is_alone ? static_cast<Word>(alone - of.begin()) : -1,
          .ratio = unwrap.ratio,
          .largest_doubt = unwrap.largest_doubt,
          .open = unwrap.open,
          .doubt_scale = unwrap.doubt_scale,
          .coordinate = GpuStages::Coordinate(unwrap.coordinate)};
}

GpuStages::Code gpu_code(const FusedStages::CodeBits& bits, Words& words) {
  const CodeStage& stage = bits.stage;
  GpuStages::Code code{.bits = static_cast<Word>(stage.frames.size()),
                       .frames = words.add_all(stage.frames),
                       .gray = stage.gray ? 1 : 0,
                       .base = stage.base,
                       .others = stage.others,
                       .against_mean = bits.against_mean ? 1 : 0,
                       .stripe = stage.stripe};
  if (!stage.inverses.empty()) code.inverses = words.add_all(stage.inverses);
  code.reference = words.place();
  words.add(static_cast<Word>(bits.reference.size()));
  words.add_all(bits.reference);
  return code;
}

GpuStages::Points gpu_points(const FusedStages& stages, Words& words) {
  const PointStage& point = stages.point;
  const ConsensusStage& consensus = stages.consensus;
  return {.coordinate = point.coordinate,
          .depth = point.depth,
          .facing = point.facing,
          .place_constant = point.place_constant,
          .place_slope = point.place_slope,
          .coordinate_offset = point.coordinate_offset,
          .depth_offset = point.depth_offset,
          .unit_scale = point.unit_scale,
          .unit_offset = point.unit_offset,
          .least_coordinate = point.least_coordinate,
          .largest_coordinate = point.largest_coordinate,
          .may_leave_field = point.may_leave_field ? 1 : 0,
          .lens_degree = point.lens_degree,
          .lens = words.add_all(point.lens),
          .low_edge = point.low_edge,
          .high_edge = point.high_edge,
          .inner_low = point.inner_low,
          .inner_high = point.inner_high,
          .nearest = point.nearest,
          .farthest = point.farthest,
          .half_fringe = consensus.half_fringe,
          .confirmed = stages.chain.empty() && !stages.cue ? 0 : 1,
          .fewest_neighbours = consensus.fewest_neighbours,
          .fewest_if_doubtful = consensus.fewest_if_doubtful};
}

GpuStages::Cue gpu_cue(const FusedStages::Cue& cue, Words& words) {
  const CueStage& stage = cue.stage;
  const OrderCostStage& costs = cue.costs;
  const float c1 = costs.share, c2 = costs.cue_share;
  std::vector<Word> lines(SurfaceWindow::line_cells.begin(), SurfaceWindow::line_cells.end());
  return {.form = 1 + static_cast<Word>(costs.form),
          .periods = stage.periods,
          .period = 1 / stage.periods,
          .gain = stage.gain,
          .offset = stage.offset,
          .largest_doubt = stage.largest_doubt,
          .share = c1,
          .cue_share = c2,
          .relative_share = c2 / c1,
          .constant_light = costs.constant_light,
          .steady = costs.steady,
          .cue_variance = costs.cue_variance,
          .relative_variance = costs.component_variance / costs.cue_variance,
          .circle_weight = 1 / ((c1 * c1 + c2 * c2) * costs.component_variance),
          .margin = costs.margin,
          .lines = words.add_all(lines)};
}

bool is_too_much(const FusedStages& stages) {
  return stages.bands.size() > GpuStages::most_bands ||
         stages.chain.size() > GpuStages::most_bands ||
         std::any_of(stages.bands.begin(), stages.bands.end(), [](const auto& band) {
           return std::max<std::ptrdiff_t>(std::ssize(band.sinusoid.cosines), band.sinusoid.steps) >
                  GpuStages::Band::most_frames;
         });
}

}  // namespace

std::optional<GpuProgramText> gpu_stages(const FusedStages& stages) {
  if (is_too_much(stages)) return std::nullopt;
  Words words;
  const Size size = stages.rays.E_x.size();
  const CoordinateStage& field = stages.cue ? stages.cue->stage.coordinate : stages.coordinate;
  GpuStages out{.width = size.width,
                .height = size.height,
                .links = static_cast<Word>(stages.chain.size()),
                .begins_with_code = stages.code ? 1 : 0,
                .coarse_in_field = stages.coarse_in_field ? 1 : 0,
                .weighs_bands = stages.weighs_bands ? 1 : 0,
                .coarse_stage = GpuStages::Coordinate(stages.coarse_stage),
                .coordinate = GpuStages::Coordinate(field),
                .weighed = GpuStages::Coordinate({1, field.period, field.cut}),
                .points = gpu_points(stages, words)};
  if (!stages.coarse.empty()) out.coarse = gpu_link(stages.coarse, {}, words);
  if (stages.code) out.code = gpu_code(*stages.code, words);
  for (std::size_t i = 0; i < stages.bands.size(); ++i) {
    out.bands[i] = gpu_band(stages.bands[i], words);
  }
  if (stages.cue) {
    out.kept = 8;
    out.cue = gpu_cue(*stages.cue, words);
    SinusoidStage channel;
    channel.cosines = stages.cue->costs.cue;
    channel.sines = stages.cue->costs.cue_sine;
    out.bands[1] = gpu_band({.sinusoid = channel}, words);
  }
  for (std::size_t i = 0; i < stages.chain.size(); ++i) {
    out.chain[i] = gpu_link(stages.chain[i].of, stages.chain[i].unwrap, words);
  }
  return GpuProgramText{out, words.take()};
}

}  // namespace slipstream
