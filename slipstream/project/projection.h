#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "slipstream/image/image.h"
#include "slipstream/opengl/window.h"

namespace slipstream::project {

/// A pattern that came on the screen: what a camera's frames are matched with.
struct PatternSwap {
  std::uint64_t sequence = 0;  ///< of swaps, from 0
  int pattern = 0;
  std::chrono::steady_clock::time_point time;  ///< of this machine, once it was shown
};

/// How patterns are shown, one after another and from the first again.
struct ProjectionSettings {
  int monitor = 0;  ///< of WindowSystem::monitors
  int hold = 1;     ///< refreshes of the monitor that each stays for
  std::function<void(const PatternSwap&)> on_swap = {};
  std::function<bool()> ends = {};  ///< asked after each refresh, beside the Esc key
};

/// What became of it.
struct ProjectionReport {
  std::uint64_t shown = 0;  ///< patterns
  std::uint64_t refreshes =
      0;                   ///< that a pattern was put on for: `hold` each, 1 or more for the last
  std::uint64_t late = 0;  ///< that came more than half a refresh after their time
  double seconds = 0;      ///< from the first to the last
  double refresh_hz = 0;   ///< as the monitor says; 60 where it does not
  bool waits_for_refresh = true;  ///< else the driver does not, and patterns went by the clock
  bool has_gamma_table = true;
};

/// Shows the patterns, which are of the monitor's size, in their order, none left out and none
/// twice, until Esc is pressed or `ends` says so; in the main thread. Throws as PatternWindow does,
/// Error where `hold` is below 1 or there is no pattern.
ProjectionReport project_patterns(const opengl::WindowSystem& system,
                                  const std::vector<Image<std::uint8_t>>& patterns,
                                  const ProjectionSettings& settings);

/// How many refreshes a pattern has to stay for so many patterns per second. Throws Error where
/// that is no whole number, to 2 %.
int refreshes_for_rate(double rate, double refresh_hz);

}  // namespace slipstream::project
