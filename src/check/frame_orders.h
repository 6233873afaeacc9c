#pragma once

#include <functional>
#include <string>
#include <vector>

#include "check/frame_model.h"
#include "slipstream/layout.h"

// Orders in which people record the frames of a cycle by mistake.
namespace slipstream {

/// Takes an order, frame `order[n]` shows pattern n, and how it came about, in words.
using AddOrder = std::function<void(const FrameOrder& order, std::string likely)>;

/// A run of the frames, optionally reversed, then rotated by `places`.
FrameOrder turned(FrameOrder order, const StepRun& run, int places, bool backwards = false);

/// Reversed and interleaved runs. Two swapped runs count as a slipped cycle instead.
void add_several_runs(const FrameOrder& right, const std::vector<StepRun>& runs,
                      const AddOrder& add);

/// Bits in reversed order, before or after their inverses.
void add_code_orders(const FrameOrder& right, const Code& code, const AddOrder& add);

/// Every run rotated by the same share of a period, forwards or reversed: the bands' phases still
/// agree. Then each run by itself.
void add_turns(const FrameOrder& right, const std::vector<StepRun>& runs, const AddOrder& add);

}  // namespace slipstream
