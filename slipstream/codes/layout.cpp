#include "slipstream/codes/layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/unwrapping_chain.h"

namespace slipstream {
namespace {

using std::numbers::pi;

constexpr double layout_rounding = 1e-9;

double sum_of(const std::vector<double>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

bool is_near(double a, double b) {
  return std::abs(a - b) <= layout_rounding;
}

void require_monotonic(const std::function<double(double)>& reference) {
  constexpr int samples = 256;
  const auto place = [](int i) { return static_cast<double>(i) / samples; };
  const double direction = reference(1) > reference(0) ? 1 : -1;
  for (int i = 0; i <= samples; ++i) {
    const double value = reference(place(i));
    const double next = reference(place(std::min(i + 1, samples)));
    if (!(std::abs(value) <= 1) || (i < samples && !(direction * (next - value) > 0))) {
      throw Error(
          fmt::format("the reference is {} at y = {}; it rises or falls throughout, within -1 to 1",
                      value, place(i)));
    }
  }
}

void require_weights(const std::vector<double>& weights, int frames, double response,
                     std::string_view name, std::string_view what) {
  const bool finite = std::all_of(weights.begin(), weights.end(),
                                  [](double weight) { return std::isfinite(weight); });
  if (static_cast<int>(weights.size()) != frames || !finite) {
    throw Error(fmt::format("{}: {} has {} weights; it takes a finite one for each of {} frames",
                            name, what, weights.size(), frames));
  }
  if (!is_near(sum_of(weights), response)) {
    throw Error(fmt::format("{}: the weights of {} add up to {}, but must to {}", name, what,
                            sum_of(weights), response));
  }
}

void require_valid(const Band& band, int frames, std::string_view name) {
  if (!(band.periods > 0 && std::isfinite(band.periods))) {
    throw Error(fmt::format("{}: {} periods are out of range; above 0", name, band.periods));
  }
  if (!(band.share > 0 && band.share <= 1)) {
    throw Error(fmt::format("{}: share {} is out of range; above 0, at most 1", name, band.share));
  }
  require_weights(band.cosine, frames, 0, name, "a cosine");
  require_weights(band.sine, frames, 0, name, "a sine");
  require_weights(band.mean, frames, 1, name, "a mean");
  if (!(band.carrier >= 0 && std::isfinite(band.carrier)) ||
      band.mirrored.size() != (band.carrier > 0 ? 1U : 0U)) {
    throw Error(
        fmt::format("{}: a carrier of {} periods with {} mirrored sinusoids; above 0 it "
                    "takes one",
                    name, band.carrier, band.mirrored.size()));
  }
  for (const Band& mirrored : band.mirrored) require_valid(mirrored, frames, name);
}

std::string periods_text(const Layout& layout) {
  std::vector<double> periods;
  for (const Band& band : layout.bands) periods.push_back(band.periods);
  for (const SingleFrame& single : layout.single_frames) periods.push_back(single.periods);
  return fmt::format("{:g}", fmt::join(periods, ", "));
}

void require_hierarchy(const Layout& layout, std::string_view name) {
  if (least_periods(layout) > 1) {
    throw Error(
        fmt::format("{}: no band has at most 1 period, from which the others are unwrapped", name));
  }
}

void require_beats(const Layout& layout, std::string_view name) {
  if (unwrapping_chain(layout).empty()) {
    throw Error(fmt::format("{}: no sum or difference of {} periods has at most 1", name,
                            periods_text(layout)));
  }
}

[[noreturn]] void refuse_repeating(const Layout& layout, std::string_view name) {
  throw Error(
      fmt::format("{}: {} periods repeat within the field; in projector pixels the lengths of "
                  "the periods must have no common multiple below that of the field",
                  name, periods_text(layout)));
}

void require_unlike(const Layout& layout, std::string_view name) {
  constexpr double least_margin = 1e-6;
  if (unwrapping_margin(layout) < least_margin) refuse_repeating(layout, name);
}

void require_code(const Layout& layout, std::string_view name) {
  if (!layout.code) throw Error(fmt::format("{}: no code to unwrap by", name));
  require_valid(*layout.code, layout.frames, name);
  const double f = measuring_band(layout).periods;
  if (layout.unwrapping == Unwrapping::code && layout.code->stripes < f - layout_rounding) {
    throw Error(fmt::format("{}: a code of {} stripes is too short for {} periods", name,
                            layout.code->stripes, f));
  }
}

void require_frames_of_surfaces(const Layout& layout, std::string_view name) {
  if (layout.bands.size() == 2 && layout.single_frames.empty()) {
    Layout alike = layout;
    alike.unwrapping = Unwrapping::likelihood;
    return require_unlike(alike, name);
  }
  const bool all = std::all_of(layout.single_frames.begin(), layout.single_frames.end(),
                               [&](const SingleFrame& single) {
                                 return single.frame >= 0 && single.frame < layout.frames &&
                                        single.periods > 0 && single.periods <= 1;
                               });
  if (all && layout.bands.size() == 1 && layout.single_frames.size() >= 3) return;
  throw Error(
      fmt::format("{}: surfaces are told by two bands, or one and three frames or more of at "
                  "most one period each",
                  name));
}

void require_single_frames(const Layout& layout, std::string_view name) {
  const bool all = std::all_of(
      layout.single_frames.begin(), layout.single_frames.end(), [&](const SingleFrame& single) {
        return single.frame >= 0 && single.frame < layout.frames && single.periods > 0;
      });
  if (layout.single_frames.empty() || !all || layout.bands.size() != 1 ||
      !step_run(layout.bands.front())) {
    throw Error(fmt::format("{}: a run of steps and frames of one sinusoid each are wanted", name));
  }
  const double f = layout.bands.front().periods;
  for (int k = 1; k < f; ++k) {
    const bool repeats = std::all_of(layout.single_frames.begin(), layout.single_frames.end(),
                                     [&](const SingleFrame& single) {
                                       const double periods = single.periods * k / f;
                                       return is_near(periods, std::round(periods));
                                     });
    if (repeats) refuse_repeating(layout, name);
  }
}

void require_cue(const Layout& layout, std::string_view name) {
  if (layout.cue) {
    const double dc = layout.cue->dc();
    require_weights(layout.cue->weights, layout.frames, dc, name, "the cue");
    if (!is_near(dc, 0) && !is_near(dc, 1)) {
      throw Error(fmt::format("{}: the cue's weights add up to {}; to 0 or 1", name, dc));
    }
    if (!(layout.cue->share > 0 && layout.cue->share < 1)) {
      throw Error(fmt::format("{}: the cue's share {} is out of range; above 0, below 1", name,
                              layout.cue->share));
    }
    if (layout.bands.size() != 1) {
      throw Error(fmt::format("{}: a cue with {} bands; it takes one", name, layout.bands.size()));
    }
  } else if (layout.bands.size() != 2 || layout.bands[1].periods != 1) {
    throw Error(fmt::format("{}: no cue, and no second band of 1 period, to vote with", name));
  }
  const double f_h = layout.bands[0].periods;
  if (f_h != std::floor(f_h)) {
    throw Error(fmt::format("{}: {} periods are not a whole number", name, f_h));
  }
}

std::vector<double> channel_weights(int steps, int channel, double (*wave)(double),
                                    const Shifts& shifts = {}) {
  const double direction = shifts.backwards ? -1 : 1;
  std::vector<double> weights;
  for (int n = 0; n < steps; ++n) {
    weights.push_back(2.0 / steps * wave(direction * 2 * pi * channel * n / steps - shifts.origin));
  }
  return weights;
}

double cosine_of(double angle) {
  return std::cos(angle);
}

double sine_of(double angle) {
  return std::sin(angle);
}

/// With zeros for the frames before and after.
std::vector<double> placed(const std::vector<double>& weights, int frames, int first) {
  std::vector<double> all(static_cast<std::size_t>(frames));
  std::copy(weights.begin(), weights.end(), all.begin() + first);
  return all;
}

bool are_near(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_near);
}

}  // namespace

CueReference::CueReference(std::function<double(double y)> function)
    : form_(Form::other), function_(std::move(function)) {
  require_monotonic(function_);
}

double CueReference::operator()(double y) const {
  const double held = std::clamp(y, 0.0, 1.0);
  switch (form_) {
    case Form::linear:
      return 2 * held - 1;
    case Form::cosine:
      return std::cos(pi * held);
    case Form::other:
      return function_(held);
  }
  return 0;
}

double CueReference::inverse(double value) const {
  const double held = std::clamp(value, -1.0, 1.0);
  if (form_ == Form::linear) return (held + 1) / 2;
  if (form_ == Form::cosine) return std::acos(held) / pi;
  const double direction = function_(1) > function_(0) ? 1 : -1;
  double low = 0, high = 1;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (low + high) / 2;
    (direction * (value - function_(middle)) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

bool operator==(const CueReference& a, const CueReference& b) {
  constexpr int places = 32;
  if (a.form_ != b.form_) return false;
  for (int i = 0; a.form_ == CueReference::Form::other && i <= places; ++i) {
    const double y = static_cast<double>(i) / places;
    if (a(y) != b(y)) return false;
  }
  return true;
}

double Cue::dc() const {
  return sum_of(weights);
}

void require_valid(const Layout& layout, std::string_view name) {
  if (layout.frames < 1 || layout.bands.empty()) {
    throw Error(fmt::format("{}: {} frames with {} bands; at least one of each is needed", name,
                            layout.frames, layout.bands.size()));
  }
  for (const Band& band : layout.bands) require_valid(band, layout.frames, name);
  switch (layout.unwrapping) {
    case Unwrapping::none:
      return;
    case Unwrapping::surfaces:
      return require_frames_of_surfaces(layout, name);
    case Unwrapping::hierarchical:
      return require_hierarchy(layout, name);
    case Unwrapping::vote:
      return require_cue(layout, name);
    case Unwrapping::beats:
      return require_beats(layout, name);
    case Unwrapping::likelihood:
      return require_unlike(layout, name);
    case Unwrapping::code:
    case Unwrapping::code_alone:
      return require_code(layout, name);
    case Unwrapping::single_frames:
      return require_single_frames(layout, name);
  }
}

std::vector<double> channel_cosines(int steps, int channel) {
  return channel_weights(steps, channel, cosine_of);
}

std::vector<double> channel_sines(int steps, int channel) {
  return channel_weights(steps, channel, sine_of);
}

std::vector<double> mean_weights(int steps) {
  return std::vector<double>(static_cast<std::size_t>(steps), 1.0 / steps);
}

std::vector<double> half_phase_weights() {
  return {0.25, -0.25, 0.25, -0.25};
}

Band phase_shifted_band(int frames, int first, int steps, double periods, int channel, double share,
                        const Shifts& shifts) {
  return {.periods = periods,
          .share = share,
          .cosine = placed(channel_weights(steps, channel, cosine_of, shifts), frames, first),
          .sine = placed(channel_weights(steps, channel, sine_of, shifts), frames, first),
          .mean = placed(mean_weights(steps), frames, first)};
}

bool is_channel(const Band& band, const StepRun& run, int channel) {
  const Band wanted = phase_shifted_band(static_cast<int>(band.mean.size()), run.first, run.steps,
                                         band.periods, channel, 1, run.shifts);
  return are_near(band.cosine, wanted.cosine) && are_near(band.sine, wanted.sine) &&
         are_near(band.mean, wanted.mean);
}

std::optional<StepRun> step_run(const Band& band) {
  const auto has_weight = [](double weight) { return weight != 0; };
  const auto first = std::find_if(band.mean.begin(), band.mean.end(), has_weight);
  const auto end = std::find_if_not(first, band.mean.end(), has_weight);
  StepRun run{static_cast<int>(first - band.mean.begin()), static_cast<int>(end - first)};
  if (run.steps < 3) return std::nullopt;
  const auto at_start = static_cast<std::size_t>(run.first);
  const double origin = std::atan2(-band.sine[at_start], band.cosine[at_start]);
  if (!is_near(origin, 0)) run.shifts.origin = origin;
  if (is_channel(band, run, 1)) return run;
  run.shifts.backwards = true;
  if (is_channel(band, run, 1)) return run;
  return std::nullopt;
}

std::optional<StepRun> bent_run(const Band& band) {
  return band.cycle ? band.cycle : step_run(band);
}

double component_noise(const Band& band) {
  const auto squares = [](const std::vector<double>& weights) {
    return std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
  };
  double noise = (squares(band.cosine) + squares(band.sine)) / 2;
  for (const Band& mirrored : band.mirrored) noise += component_noise(mirrored);
  return noise;
}

std::vector<int> step_counts(const Layout& layout) {
  std::vector<int> counts;
  for (const Band& band : layout.bands) {
    if (const auto run = bent_run(band)) counts.push_back(run->steps);
  }
  return counts;
}

std::vector<std::size_t> coarse_to_fine(const Layout& layout) {
  std::vector<std::size_t> order(layout.bands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // Of two alike the first one measures.
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(layout.bands[a].periods, b) < std::pair(layout.bands[b].periods, a);
  });
  return order;
}

std::size_t measuring_band_index(const Layout& layout) {
  return coarse_to_fine(layout).back();
}

const Band& measuring_band(const Layout& layout) {
  return layout.bands[measuring_band_index(layout)];
}

std::vector<int> measuring_frames(const Layout& layout) {
  std::vector<int> frames;
  for (int n = 0; n < layout.frames && layout.unwrapping != Unwrapping::code_alone; ++n) {
    const auto i = static_cast<std::size_t>(n);
    const bool in_band =
        std::any_of(layout.bands.begin(), layout.bands.end(), [i](const Band& band) {
          return band.cosine[i] != 0 || band.sine[i] != 0 || band.mean[i] != 0;
        });
    const bool alone = std::any_of(layout.single_frames.begin(), layout.single_frames.end(),
                                   [n](const SingleFrame& single) { return single.frame == n; });
    if (in_band || alone || (layout.cue && layout.cue->weights[i] != 0)) frames.push_back(n);
  }
  return frames;
}

bool has_coordinate(const Layout& layout) {
  return layout.unwrapping != Unwrapping::none || measuring_band(layout).periods <= 1;
}

bool needs_ambient_light(const Layout& layout) {
  return layout.cue && std::abs(layout.cue->dc()) > 0.5;
}

double carrier_periods(const Layout& layout) {
  double most = 0;
  for (const Band& band : layout.bands) most = std::max(most, band.carrier);
  return most;
}

double highest_frequency(const Layout& layout) {
  return measuring_band(layout).periods;
}

}  // namespace slipstream
