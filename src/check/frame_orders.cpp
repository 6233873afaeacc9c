#include "check/frame_orders.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace slipstream {

FrameOrder turned(FrameOrder order, const StepRun& run, int places, bool backwards) {
  const auto begin = order.begin() + run.first, end = begin + run.steps;
  if (backwards) std::reverse(begin, end);
  std::rotate(begin, begin + places, end);
  return order;
}

void add_several_runs(const FrameOrder& right, const std::vector<StepRun>& runs,
                      const AddOrder& add) {
  if (runs.size() > 1) add({right.rbegin(), right.rend()}, "all frames are in reversed order");

  const int bands = static_cast<int>(runs.size()), steps = runs.front().steps;
  const bool alike =
      std::ranges::all_of(runs, [&](const StepRun& run) { return run.steps == steps; });
  if (bands < 2 || !alike) return;

  // The frames of all runs, one run after the other.
  std::vector<int> places;
  for (const StepRun& run : runs) {
    for (int n = 0; n < steps; ++n) places.push_back(run.first + n);
  }

  // A loop over the steps around one over the bands, the first band or the last one first.
  for (const bool backwards : {false, true}) {
    FrameOrder in_turns = right;
    for (int band = 0; band < bands; ++band) {
      const int turn = backwards ? bands - 1 - band : band;
      for (int n = 0; n < steps; ++n) in_turns[places[band * steps + n]] = places[n * bands + turn];
    }
    add(in_turns, fmt::format("the frames of the {}bands are interleaved: each step of all bands "
                              "in turn",
                              bands == 2 ? "two " : ""));
  }
}

void add_code_orders(const FrameOrder& right, const Code& code, const AddOrder& add) {
  const std::vector<int>&bits = code.frames, &inverses = code.inverses;
  const std::size_t count = bits.size();

  // The frames of the code, in the order of capture.
  std::vector<int> places = bits;
  places.insert(places.end(), inverses.begin(), inverses.end());
  std::ranges::sort(places);

  FrameOrder reversed = right, before = right, after = right;

  for (std::size_t i = 0; i < count; ++i) {
    const int bit = bits[i];
    reversed[bit] = bits[count - 1 - i];

    if (inverses.empty()) continue;
    const int inverse = inverses[i];
    reversed[inverse] = inverses[count - 1 - i];

    std::swap(before[bit], before[inverse]);
    after[bit] = places[i];
    after[inverse] = places[count + i];
  }

  add(reversed, "the bits of the code are in reversed order");
  add(before, "each bit of the code comes after its inverse");
  add(after, "the inverses come after all bits of the code");
}

void add_turns(const FrameOrder& right, const std::vector<StepRun>& runs, const AddOrder& add) {
  // The number of equal parts into which every run can be divided.
  int least = runs.front().steps;
  for (const StepRun& run : runs) least = std::gcd(least, run.steps);

  for (int part = 0; part < least; ++part) {
    for (const bool backwards : {false, true}) {
      FrameOrder order = right;
      for (const StepRun& run : runs)
        order = turned(order, run, part * run.steps / least, backwards);

      add(order, backwards          ? "the frames of each band are in reversed order"
                 : runs.size() == 1 ? fmt::format("the frames are rotated by {}", part)
                                    : "the frames of each band are rotated");
    }
  }

  for (const StepRun& run : runs) {
    const std::string frames = fmt::format("frames {} to {}", run.first, run.first + run.steps - 1);
    for (int n = 1; n < run.steps; ++n)
      add(turned(right, run, n), fmt::format("{} look rotated by {}", frames, run.steps - n));
    for (int n = 0; n < run.steps; ++n)
      add(turned(right, run, n, true), fmt::format("{} look reversed", frames));
  }
}

}  // namespace slipstream
