#include "slipstream/codes/sequence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/motion_window.h"

namespace slipstream {
namespace {

constexpr std::string_view both = "both";

}  // namespace

Sequence along(Sequence sequence, Axis axis) {
  sequence.axis = axis;
  sequence.both_axes = false;
  return sequence;
}

std::string_view axes_of(const Sequence& sequence) {
  return sequence.both_axes ? both : name_of(sequence.axis);
}

void set_axes(Sequence& sequence, std::string_view axes) {
  if (axes != both && axes != "x" && axes != "y") {
    throw Error(fmt::format("axis '{}' is not known; it is x, y or both", axes));
  }
  sequence.both_axes = axes == both;
  sequence.axis = sequence.both_axes ? Axis::x : axis_named(axes);
}

int frame_count(const Sequence& sequence) {
  return static_cast<int>(sequence.exposures.size()) * (sequence.both_axes ? 2 : 1) *
             frame_count(sequence.strategy) +
         sequence.motion;
}

int cycle_length(const Sequence& sequence) {
  return frame_count(cycle_of(sequence)) + (sequence.marker ? 1 : 0);
}

Sequence cycle_of(Sequence sequence) {
  sequence.motion = 0;
  return sequence;
}

PatternSet pattern_set(const Sequence& sequence) {
  PatternSet patterns = pattern_set(sequence.strategy, sequence.axis, sequence.light);
  patterns.shape = [shape = patterns.shape, N = patterns.count](int n, double y, double across) {
    return shape(n % N, y, across);
  };
  if (sequence.both_axes) patterns.turn = patterns.count;
  const int each = frame_count(sequence) / static_cast<int>(sequence.exposures.size());
  for (const double exposure : sequence.exposures) {
    patterns.exposures.insert(patterns.exposures.end(), static_cast<std::size_t>(each), exposure);
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
  const bool positive = std::all_of(exposures.begin(), exposures.end(),
                                    [](double t) { return t > 0 && std::isfinite(t); });
  if (exposures.empty() || exposures.size() > most || !positive) {
    throw Error(fmt::format("exposures {} are out of range; 1 to {} numbers above 0",
                            fmt::join(exposures, ", "), most));
  }
  if (sequence.motion != 0) {
    if (exposures.size() > 1 || sequence.both_axes || sequence.marker) {
      throw Error(
          "frames of things that move come at one pace from one cycle: without several exposures, "
          "both axes or a marker");
    }
    motion_window(sequence.strategy.layout(), sequence.motion);
  }
  if (sequence.strategy.demodulation() && (exposures.size() > 1 || sequence.motion != 0)) {
    throw Error(
        fmt::format("{} is read from the surroundings in each frame: of one exposure, and "
                    "without frames of motion",
                    sequence.strategy.name()));
  }
  if (exposures.size() > 1 && needs_ambient_light(sequence.strategy.layout())) {
    throw Error(
        fmt::format("{} of {} frames takes one exposure: its cue is read from the ambient "
                    "light, which merged frames do not hold alike",
                    sequence.strategy.name(), frame_count(sequence.strategy)));
  }
}

std::vector<PatternSet> along_both_axes(const Sequence& sequence) {
  Sequence along_x = along(sequence, Axis::x);
  along_x.marker = false;
  return {pattern_set(along_x), pattern_set(along(sequence, Axis::y))};
}

void require_in_colour(const Sequence& sequence, const std::string& asked) {
  if (frame_count(sequence) % 3 == 0 && !sequence.marker) return;
  throw Error(fmt::format(
      "{}: {} has {} frames{}; in colour three each make a picture, without a marker", asked,
      sequence.strategy.name(), frame_count(sequence), sequence.marker ? " and a marker" : ""));
}

void require_shown(const Sequence& sequence) {
  if (sequence.projector == Size{}) return;
  for (const Axis axis : {Axis::x, Axis::y}) {
    if (!sequence.both_axes && axis != sequence.axis) continue;
    require_resolved(sequence.strategy, axis, sequence.projector);
  }
}

}  // namespace slipstream
