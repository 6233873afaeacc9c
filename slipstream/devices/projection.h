#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "slipstream/frames/pattern_sink.h"

namespace slipstream::monitor {

/// A pattern that came on the screen: what a camera's frames are matched with.
struct PatternSwap {
  std::uint64_t sequence = 0;  ///< of swaps, from 0
  int pattern = 0;
  std::chrono::steady_clock::time_point time;  ///< of this machine, once it was shown
};

/// How patterns are shown, one after another and from the first again.
struct ProjectionSettings {
  double refresh_hz = 60;  ///< of the projector, as MonitorSink::refresh_hz
  int hold = 1;            ///< refreshes of the projector that each stays for
  std::function<void(const PatternSwap&)> on_swap = {};
  std::function<bool()> ends = {};  ///< asked after each refresh
};

/// What became of it.
struct ProjectionReport {
  std::uint64_t shown = 0;  ///< patterns
  std::uint64_t refreshes =
      0;                   ///< that a pattern was put on for: `hold` each, 1 or more for the last
  std::uint64_t late = 0;  ///< that came more than half a refresh after their time
  double seconds = 0;      ///< from the first to the last
  /// Whether show() waits for the projector's refresh; else patterns went by the clock.
  bool waits_for_refresh = true;
};

/// Shows the `count` patterns that `sink` has loaded in their order, over and over, none left out
/// and none twice, until `ends` says so. Throws as the sink does, Error where `hold` is below 1,
/// the rate is not above 0 or there is no pattern.
ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings);

/// How many refreshes a pattern has to stay for so many patterns per second. Throws Error where
/// that is no whole number, to 2 %.
int refreshes_for_rate(double rate, double refresh_hz);

/// The same where the rate or the refreshes may be given: 1 where neither is. Throws Error as well
/// where both are, the refreshes are below 1, or the rate is given and it is not known how often
/// the projector refreshes (0).
int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz);

}  // namespace slipstream::monitor
