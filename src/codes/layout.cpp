#include "slipstream/layout.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "base/throw_if-inl.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

int bit_count(const Code& code) {
  return static_cast<int>(code.frames.size());
}

/// Mask of the bit in a code word.
unsigned place(const Code& code, int bit) {
  return 1U << static_cast<unsigned>(bit_count(code) - 1 - bit);
}

/// All bits except the base.
unsigned others(const Code& code) {
  return ((1U << code.frames.size()) - 1) & ~place(code, *code.base);
}

double reference_of(const Code& code, std::span<const double> I) {
  if (!code.reference.empty()) {
    return std::inner_product(I.begin(), I.end(), code.reference.begin(), 0.0);
  }

  // Otherwise half way between the darkest and the brightest bit.
  double darkest = std::numeric_limits<double>::infinity(), brightest = 0;
  for (const int frame : code.frames) {
    darkest = std::min(darkest, I[frame]);
    brightest = std::max(brightest, I[frame]);
  }

  return (darkest + brightest) / 2;
}

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
    throw_if(!(std::abs(value) <= 1) || (i < samples && !(direction * (next - value) > 0)),
             "the reference is {} at y = {}; it must be monotonic and within -1 to 1", value,
             place(i));
  }
}

void require_weights(const std::vector<double>& weights, int frames, double response,
                     std::string_view name, std::string_view what) {
  const bool finite =
      std::ranges::all_of(weights, [](double weight) { return std::isfinite(weight); });
  throw_if(static_cast<int>(weights.size()) != frames || !finite,
           "{}: {} has {} weights; expected a finite one for each of {} frames", name, what,
           weights.size(), frames);

  // Constant light gives 0 in C and S, and 1 in the mean.
  throw_if(!is_near(sum_of(weights), response), "{}: the weights of {} sum to {}; expected {}",
           name, what, sum_of(weights), response);
}

void require_valid(const Band& band, int frames, std::string_view name) {
  throw_if(!(band.periods > 0 && std::isfinite(band.periods)),
           "{}: {} periods are out of range; above 0", name, band.periods);
  throw_if(!(band.share > 0 && band.share <= 1), "{}: share {} is out of range; above 0, at most 1",
           name, band.share);

  // C and S ignore constant light; the mean keeps it.
  require_weights(band.cosine, frames, 0, name, "a cosine");
  require_weights(band.sine, frames, 0, name, "a sine");
  require_weights(band.mean, frames, 1, name, "a mean");

  // A carrier makes two oblique sinusoids; the second must be valid too.
  throw_if(!(band.carrier >= 0 && std::isfinite(band.carrier)) ||
               band.mirrored.size() != (band.carrier > 0 ? 1U : 0U),
           "{}: a carrier of {} periods with {} mirrored sinusoids; above 0 it requires one", name,
           band.carrier, band.mirrored.size());
  for (const Band& mirrored : band.mirrored) require_valid(mirrored, frames, name);
}

bool are_near(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_near);
}

}  // namespace

void require_valid(const Code& code, int frames, std::string_view name) {
  const int bits = bit_count(code);
  throw_if(bits < 1 || bits > most_code_bits, "{}: {} bits are out of range; 1 to {}", name, bits,
           most_code_bits);
  throw_if(!(code.stripes >= 2 && code.stripes <= std::exp2(bits)),
           "{}: {} bits encode 2 to {} stripes; {:g} is out of range", name, bits, std::exp2(bits),
           code.stripes);

  // Every bit needs its frames, and a threshold or an inverse.
  const auto is_frame = [&](int frame) { return frame >= 0 && frame < frames; };
  const bool all =
      std::ranges::all_of(code.frames, is_frame) && std::ranges::all_of(code.inverses, is_frame);
  const bool compared =
      code.inverses.empty()
          ? code.reference.empty() || static_cast<int>(code.reference.size()) == frames
          : code.inverses.size() == code.frames.size();

  throw_if(!all || !compared || (code.base && !(*code.base >= 0 && *code.base < bits)),
           "{}: bits, inverses, weights or base of the code do not fit {} frames", name, frames);
}

bool is_bright(const Code& code, int bit, double y) {
  // The last stripe may be narrower. A tiny shift keeps rounding from moving y below an edge.
  const double last = std::ceil(code.stripes) - 1;
  const auto stripe =
      static_cast<unsigned>(std::clamp(std::floor(y * code.stripes + 1e-9), 0.0, last));

  // The stripe's code word. The base's pattern inverts all other bits.
  unsigned word = code.gray ? stripe ^ (stripe >> 1U) : stripe;
  if (code.base && (word & place(code, *code.base)) != 0) word ^= others(code);

  return (word & place(code, bit)) != 0;
}

double code_intensity(const Code& code, int n, double y) {
  const auto in = [n](const std::vector<int>& frames) {
    return static_cast<int>(std::ranges::find(frames, n) - frames.begin());
  };

  // A bit's own frame, or its inverse.
  if (const int bit = in(code.frames); bit < bit_count(code)) return is_bright(code, bit, y);
  if (const int bit = in(code.inverses); bit < static_cast<int>(code.inverses.size())) {
    return !is_bright(code, bit, y);
  }

  // The frame after the bits is white, the one after that black.
  return n == std::ranges::max(code.frames) + 1;
}

int stripe_of(const Code& code, unsigned shown) {
  // 1. Undo the XOR with the base's pattern.
  if (code.base && (shown & place(code, *code.base)) != 0) shown ^= others(code);

  // 2. Gray code to binary: each bit is XORed with all higher ones.
  if (!code.gray) return static_cast<int>(shown);
  for (unsigned shift = 1; shift < most_code_bits; shift *= 2) shown ^= shown >> shift;
  return static_cast<int>(shown);
}

int first_pixel(const Code& code, int stripe, int pixels) {
  // is_bright tolerates as much.
  constexpr double rounding = 1e-9;
  const double edge = (stripe - rounding) / code.stripes * pixels;
  return static_cast<int>(std::ceil(std::min(edge, 2.0 * pixels)));
}

CodeBits code_bits(const Code& code, std::span<const double> I, double tolerance) {
  const double reference = reference_of(code, I);
  CodeBits bits;

  for (std::size_t bit = 0; bit < code.frames.size(); ++bit) {
    const double level = I[code.frames[bit]];
    // Half the difference from the inverse is the distance from the mean of both.
    const double above =
        code.inverses.empty() ? level - reference : (level - I[code.inverses[bit]]) / 2;

    bits.shown = 2 * bits.shown + (above > 0 ? 1U : 0U);
    bits.doubtful = 2 * bits.doubtful + (std::abs(above) < tolerance ? 1U : 0U);
  }

  return bits;
}

CodeReading read_code(const Code& code, std::span<const double> I, double noise) {
  constexpr int most_doubtful = 4;  // an edge, and the finest stripes blurred

  // A bit minus the mean of white and black deviates by 1.2 times the noise: at this tolerance,
  // 0.7 % are misread.
  const auto [darkest, brightest] = std::ranges::minmax(I);
  const auto [shown, doubtful] = code_bits(code, I, 3 * noise);
  const bool readable = std::popcount(doubtful) <= most_doubtful;

  // Flip every subset of the doubtful bits to find the first and the last stripe they allow.
  int first = stripe_of(code, shown), last = first;
  for (unsigned wrong = readable ? doubtful : 0; wrong != 0; wrong = (wrong - 1) & doubtful) {
    const int stripe = stripe_of(code, shown ^ wrong);
    first = std::min(first, stripe);
    last = std::max(last, stripe);
  }

  // With too many doubtful bits every stripe is possible.
  return {.first = first,
          .last = last,
          .spread = readable ? last - first : code.stripes,
          .contrast = (brightest - darkest) / 2};
}

double shifted_phase(const Shifts& shifts, double phi) {
  return shifts.backwards ? -phi - shifts.origin : phi + shifts.origin;
}

double unshifted_phase(const Shifts& shifts, double shifted) {
  const double phi = (shifts.backwards ? -shifted : shifted) - shifts.origin;
  const double turned = phi - 2 * pi * std::floor(phi / (2 * pi));
  return turned > 2 * pi - 1e-12 ? 0 : turned;  // rounded as in wrapped_angle
}

CueReference::CueReference(std::function<double(double y)> function)
    : form_(Form::other), function_(std::move(function)) {
  require_monotonic(function_);
}

double CueReference::operator()(double y) const {
  const double held = std::clamp(y, 0.0, 1.0);
  if (form_ == Form::linear) return 2 * held - 1;
  return form_ == Form::cosine ? std::cos(pi * held) : function_(held);
}

double CueReference::inverse(double value) const {
  const double held = std::clamp(value, -1.0, 1.0);
  if (form_ == Form::linear) return (held + 1) / 2;
  if (form_ == Form::cosine) return std::acos(held) / pi;

  // Bisection: 50 halvings of the field reach the rounding of a double.
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

  // Custom functions are equal if they agree at all sample places.
  for (int i = 0; a.form_ == CueReference::Form::other && i <= places; ++i) {
    const double y = static_cast<double>(i) / places;
    if (a(y) != b(y)) return false;
  }

  return true;
}

double Cue::dc() const {
  return sum_of(weights);
}

void require_valid(const Cue& cue, int frames, std::string_view name) {
  const double dc = cue.dc();
  require_weights(cue.weights, frames, dc, name, "the cue");

  throw_if(!is_near(dc, 0) && !is_near(dc, 1), "{}: the cue's weights sum to {}; expected 0 or 1",
           name, dc);

  throw_if(!(cue.share > 0 && cue.share < 1),
           "{}: the cue's share {} is out of range; above 0, below 1", name, cue.share);
}

void require_valid(const Layout& layout, std::string_view name) {
  throw_if(layout.frames < 1 || layout.bands.empty(),
           "{}: {} frames with {} bands; at least one of each is required", name, layout.frames,
           layout.bands.size());
  for (const Band& band : layout.bands) require_valid(band, layout.frames, name);
  if (const auto require = layout.unwrapping->require) require(layout, name);
}

Band phase_shifted_band(int frames, int first, int steps, double periods, int channel, double share,
                        const Shifts& shifts) {
  const std::vector<double> none(frames);
  Band band{.periods = periods, .share = share, .cosine = none, .sine = none, .mean = none};
  const double direction = shifts.backwards ? -1 : 1;

  for (int n = 0; n < steps; ++n) {
    const double angle = direction * 2 * pi * channel * n / steps - shifts.origin;
    band.cosine[first + n] = 2.0 / steps * std::cos(angle);
    band.sine[first + n] = 2.0 / steps * std::sin(angle);
    band.mean[first + n] = 1.0 / steps;
  }

  return band;
}

bool is_channel(const Band& band, const StepRun& run, int channel) {
  const Band wanted = phase_shifted_band(static_cast<int>(band.mean.size()), run.first, run.steps,
                                         band.periods, channel, 1, run.shifts);
  return are_near(band.cosine, wanted.cosine) && are_near(band.sine, wanted.sine) &&
         are_near(band.mean, wanted.mean);
}

std::optional<StepRun> step_run(const Band& band) {
  // The steps are the frames that count towards the mean.
  const auto has_weight = [](double weight) { return weight != 0; };
  const auto first = std::ranges::find_if(band.mean, has_weight);
  const auto end = std::find_if_not(first, band.mean.end(), has_weight);
  StepRun run{static_cast<int>(first - band.mean.begin()), static_cast<int>(end - first)};
  if (run.steps < 3) return std::nullopt;

  // The first step's weights give the origin. The direction is the one that fits.
  const double origin = std::atan2(-band.sine[run.first], band.cosine[run.first]);
  if (!is_near(origin, 0)) run.shifts.origin = origin;

  if (is_channel(band, run, 1)) return run;
  run.shifts.backwards = true;
  if (is_channel(band, run, 1)) return run;

  return std::nullopt;
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
  // The first of two with equal periods measures.
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return std::pair(layout.bands[a].periods, b) < std::pair(layout.bands[b].periods, a);
  });
  return order;
}

std::size_t measuring_band_index(const Layout& layout) {
  return coarse_to_fine(layout).back();
}

std::vector<int> measuring_frames(const Layout& layout) {
  std::vector<int> frames;
  // A code alone has none: it is only thresholded.
  for (int n = 0; n < layout.frames && !layout.unwrapping->whole_stripes; ++n) {
    const auto counts = [n](const Band& band) {
      return band.cosine[n] != 0 || band.sine[n] != 0 || band.mean[n] != 0;
    };

    const bool in_band = std::ranges::any_of(layout.bands, [&](const Band& band) {
      return counts(band) || std::ranges::any_of(band.mirrored, counts);
    });
    const bool alone = std::ranges::count(layout.single_frames, n, &SingleFrame::frame) > 0;

    if (in_band || alone || (layout.cue && layout.cue->weights[n] != 0)) frames.push_back(n);
  }

  return frames;
}

bool has_coordinate(const Layout& layout) {
  return layout.unwrapping->gives_coordinate || measuring_band(layout).periods <= 1;
}

bool needs_ambient_light(const Layout& layout) {
  return layout.cue && std::abs(layout.cue->dc()) > 0.5;
}

std::vector<StepRun> step_runs(const Layout& layout) {
  std::vector<StepRun> runs;
  for (const Band& band : layout.bands) {
    const auto run = step_run(band);
    if (run && std::ranges::count(runs, *run) == 0) runs.push_back(*run);
  }

  return runs;
}

double carrier_periods(const Layout& layout) {
  return std::ranges::max_element(layout.bands, {}, &Band::carrier)->carrier;
}

}  // namespace slipstream
