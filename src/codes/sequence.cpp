#include "slipstream/sequence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/throw_if-inl.h"
#include "codes/motion_window.h"

namespace slipstream {
namespace {

constexpr std::string_view both = "both";

/// Periods of this length across the field, both in projector pixels.
double periods_across(double length, double field, bool coarse) {
  constexpr double most_missing = 1.5;  // pixels

  // A period longer than the field is shown as one. So is the coarsest of several if its last
  // pixels are missing: np.linspace(0, 2 pi, width) counts both ends, so that the period is a pixel
  // shorter than the field. It only counts the periods of the others, which tolerate that.
  if (length > field || (coarse && length >= field - most_missing)) return 1;
  return field / length;
}

/// Sets the periods by the strategy's own settings: `periods`, `frequency`, or `high` and `low`.
void set_periods(std::string_view strategy, std::vector<double> periods,
                 StrategySettings& settings) {
  const StrategySettings usual = make_strategy(strategy, {}).settings();
  std::vector<const char*> names;

  if (usual.contains("periods")) {
    settings["periods"] = periods;
    return;
  }
  if (usual.contains("frequency")) names = {"frequency"};
  if (usual.contains("high")) names = {"high", "low"};

  throw_if(names.empty(), "{} has no periods, so that none can be given in pixels", strategy);
  throw_if(periods.size() > names.size(), "{} takes {} lengths of periods, not {}", strategy,
           names.size(), periods.size());

  // The most periods are the high frequency.
  std::ranges::sort(periods, std::greater());
  for (std::size_t i = 0; i < periods.size(); ++i) settings[names[i]] = periods[i];
}

/// Converts lengths in projector pixels to periods and stripes across the field, `field` pixels.
void add_settings_in_pixels(const StrategySettings& lengths, int field, std::string_view strategy,
                            StrategySettings& settings) {
  for (const auto& [name, value] : lengths) {
    throw_if(field == 0,
             "lengths in projector pixels require the projector size, e.g. `projector 1920x1080`");

    std::vector<double> numbers;
    value.read(numbers);
    const bool several = numbers.size() > 1;
    for (double& number : numbers) {
      throw_if(!(number > 0), "a length of {} projector pixels is out of range; above 0", number);
      number = periods_across(number, field, several);
    }

    if (name == "periods") {
      set_periods(strategy, std::move(numbers), settings);
    } else {
      settings[name] = numbers;
    }
  }
}

/// The strategy with other settings. If the known one reads demodulated frames, so does this.
Strategy with_settings(const Strategy& known, std::string_view name,
                       const StrategySettings& settings) {
  const Strategy strategy = make_strategy(name, settings);
  const bool read = known.is_spectral() && !known.demodulation() && name == known.name();
  return read ? strategy.read_as() : strategy;
}

}  // namespace

Sequence along(Sequence sequence, Axis axis) {
  // A length in pixels makes a different number of periods along the other axis.
  if (axis != sequence.axis && !sequence.lengths.empty()) {
    StrategySettings settings = sequence.strategy.settings();
    add_settings_in_pixels(sequence.lengths, length_along(axis, sequence.projector),
                           sequence.strategy.name(), settings);
    sequence.strategy = with_settings(sequence.strategy, sequence.strategy.name(), settings);
  }

  sequence.axis = axis;
  sequence.both_axes = false;
  return sequence;
}

std::string_view axes_of(const Sequence& sequence) {
  return sequence.both_axes ? both : name_of(sequence.axis);
}

void set_axes(Sequence& sequence, std::string_view axes) {
  throw_if(axes != both && axes != "x" && axes != "y",
           "axis '{}' is unknown; expected x, y or both", axes);
  sequence.both_axes = axes == both;
  sequence.axis = sequence.both_axes ? Axis::x : axis_named(axes);
}

std::vector<int> frames_along_axes(const Sequence& sequence) {
  std::vector<int> counts{frame_count(sequence.strategy)};
  if (sequence.both_axes) {
    counts.push_back(frame_count(along(sequence, across(sequence.axis)).strategy));
  }
  return counts;
}

int frame_count(const Sequence& sequence) {
  const std::vector<int> counts = frames_along_axes(sequence);
  const int each = std::accumulate(counts.begin(), counts.end(), 0);
  return static_cast<int>(sequence.exposures.size()) * each + sequence.motion;
}

Sequence cycle_of(Sequence sequence) {
  sequence.motion = 0;
  return sequence;
}

PatternSet pattern_set(const Sequence& sequence) {
  PatternSet patterns = pattern_set(sequence.strategy, sequence.axis, sequence.light);

  // Along both axes: those along the other one follow.
  PatternShape turned = patterns.shape;
  int both = patterns.count;
  if (sequence.both_axes) {
    const PatternSet other =
        pattern_set(along(sequence, across(sequence.axis)).strategy, Axis::y, {});
    turned = other.shape;
    both += other.count;
    patterns.turn = patterns.count;
    patterns.along_other = other.count;
  }

  patterns.shape = [shape = patterns.shape, turned, first = patterns.count, both](int n, double y,
                                                                                  double across) {
    const int pattern = n % both;
    return pattern < first ? shape(pattern, y, across) : turned(pattern - first, y, across);
  };

  // All patterns with the first exposure, then all with the next.
  const int each = frame_count(sequence) / static_cast<int>(sequence.exposures.size());
  for (const double exposure : sequence.exposures) {
    patterns.exposures.insert(patterns.exposures.end(), each, exposure);
  }

  patterns.count = frame_count(sequence);
  patterns.binary = sequence.binary;

  return sequence.marker ? with_marker(std::move(patterns)) : patterns;
}

Sequence merged_sequence(Sequence sequence, int first) {
  sequence.exposures = {1};
  sequence.strategy = sequence.strategy.read_as();
  if (sequence.motion > 0) sequence.strategy = sequence.strategy.in_motion(sequence.motion, first);
  sequence.motion = 0;
  return sequence;
}

void require_mergeable(const Sequence& sequence) {
  constexpr std::size_t most = 16;
  const std::vector<double>& exposures = sequence.exposures;
  const bool positive =
      std::ranges::all_of(exposures, [](double t) { return t > 0 && std::isfinite(t); });

  throw_if(exposures.empty() || exposures.size() > most || !positive,
           "exposures {} are out of range; expected 1 to {} numbers above 0",
           fmt::join(exposures, ", "), most);

  // Motion windows run over repeated cycles of equal steps; motion_window refuses other layouts.
  if (sequence.motion != 0) {
    throw_if(exposures.size() > 1 || sequence.both_axes || sequence.marker,
             "motion compensation does not support several exposures, both axes or a marker");

    motion_window(sequence.strategy.layout(), sequence.motion);
  }

  throw_if(
      sequence.strategy.demodulation() && (exposures.size() > 1 || sequence.motion != 0),
      "{} does not support several exposures or motion compensation: each frame is decoded on its "
      "own",
      sequence.strategy.name());

  throw_if(
      exposures.size() > 1 && needs_ambient_light(sequence.strategy.layout()),
      "{} with {} frames supports only one exposure: its cue requires the ambient light, which "
      "varies in merged frames",
      sequence.strategy.name(), frame_count(sequence.strategy));
}

std::vector<PatternSet> along_both_axes(const Sequence& sequence) {
  Sequence along_x = along(sequence, Axis::x);
  along_x.marker = false;
  return {pattern_set(along_x), pattern_set(along(sequence, Axis::y))};
}

void require_in_colour(const Sequence& sequence, const std::string& asked) {
  throw_if(frame_count(sequence) % 3 != 0 || sequence.marker,
           "{}: {} has {} frames{}; colour pictures require a multiple of 3, without a marker",
           asked, sequence.strategy.name(), frame_count(sequence),
           sequence.marker ? " and a marker" : "");
}

void require_shown(const Sequence& sequence) {
  if (sequence.projector == Size{}) return;
  for (const Axis axis : {Axis::x, Axis::y}) {
    if (!sequence.both_axes && axis != sequence.axis) continue;
    require_resolved(along(sequence, axis).strategy, axis, sequence.projector);
  }
}

Sequence changed(const Sequence& first, const SequenceChanges& changes) {
  const Sequence& known = changes.known ? *changes.known : first;
  const bool replaced = changes.strategy && *changes.strategy != known.strategy.name();
  StrategySettings settings = replaced ? StrategySettings{} : known.strategy.settings();
  Sequence sequence = known;
  if (replaced) sequence.lengths.clear();

  // 1. Steps and shifts.
  const auto is_given = [&](const std::string& name) {
    return changes.settings.contains(name) && changes.settings.at(name);
  };
  // Either replaces the other; make_strategy refuses both.
  if (is_given("steps")) settings.erase("shifts");
  for (const char* const name : {"steps", "low_steps"}) {
    if (is_given("shifts")) settings.erase(name);
  }

  // 2. Other settings. A setting in pixels gives way to one that is given directly.
  for (const auto& [name, value] : changes.settings) {
    if (!value) continue;
    settings[name] = *value;
    const bool is_periods = name == "frequency" || name == "high" || name == "low";
    sequence.lengths.erase(is_periods ? "periods" : name);
  }

  // 3. Lengths in projector pixels. Their periods depend on the axis and the projector's size.
  if (changes.stripe_pixels) sequence.lengths["stripes"] = *changes.stripe_pixels;
  if (changes.period_pixels) sequence.lengths["periods"] = *changes.period_pixels;

  if (changes.axes) set_axes(sequence, *changes.axes);
  if (sequence.projector == Size{}) sequence.projector = first.projector;
  sequence.projector = changes.projector.value_or(sequence.projector);

  const std::string strategy = changes.strategy.value_or(std::string(known.strategy.name()));
  StrategySettings in_pixels;
  add_settings_in_pixels(sequence.lengths, length_along(sequence.axis, sequence.projector),
                         strategy, in_pixels);
  for (const auto& [name, value] : in_pixels) {
    throw_if(is_given(name), "`{}` and `{}` are both given; leave out one", name,
             name == "stripes" ? "stripe" : "period_pixels");
    settings[name] = value;
  }
  sequence.strategy = with_settings(known.strategy, strategy, settings);

  // 4. How the patterns are shown and seen.
  sequence.light.alpha_p = changes.alpha_p.value_or(known.light.alpha_p);
  sequence.light.beta_p = changes.beta_p.value_or(known.light.beta_p);
  require_valid(sequence.light);

  sequence.exposures = changes.exposures.value_or(known.exposures);
  sequence.marker = known.marker || changes.marker;
  sequence.binary = known.binary || changes.binary;
  sequence.motion = changes.motion.value_or(known.motion);

  require_mergeable(sequence);
  return sequence;
}

Sequence default_sequence(Size projector, const SequenceChanges& changes) {
  const Sequence sequence =
      changed({.strategy = default_strategy(), .projector = projector}, changes);
  require_shown(sequence);
  return sequence;
}

}  // namespace slipstream
