#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/image.h"
#include "view/opengl.h"

namespace slipstream::monitor {

/// A monitor used as a projector: pixel for pixel, without frame or cursor. Its gamma table is the
/// identity until the window system ends, so that grey levels are unchanged. Main thread only,
/// except that another thread may load and show patterns.
class MonitorSink : public PatternSink {
 public:
  /// `monitor`: index into WindowSystem::monitors. Throws Error if missing, WorldError without
  /// OpenGL.
  MonitorSink(const opengl::WindowSystem& system, int monitor);
  ~MonitorSink() override;

  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  /// The same for colour pictures.
  void load_in_colour(std::vector<Image<Colour>> pictures);
  /// Shows pattern n from the next refresh; returns once the refresh has begun, if the driver waits
  /// for it.
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override;

  /// Draws pattern n into the hidden buffer, which can be read back; main thread.
  void draw(std::size_t n) const;
  /// The monitor's reported refresh rate; 60 if unknown.
  [[nodiscard]] double refresh_hz() const { return refresh_hz_; }
  /// Whether the monitor has a gamma table that was set.
  [[nodiscard]] bool has_gamma_table() const { return has_gamma_table_; }
  /// Whether Esc was pressed, the window closed or the desktop ended. Processes window events.
  [[nodiscard]] bool closed() const;

 private:
  template <class Pixel>
  void load_all(const std::vector<Image<Pixel>>& patterns);

  int monitor_;
  double refresh_hz_;
  opengl::Window window_;
  bool has_gamma_table_;
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_;
  std::vector<opengl::Resource> textures_;
  Size size_;
  std::uint64_t shown_ = 0;
};

/// A displayed pattern, to match with a camera's frames.
struct PatternSwap {
  std::uint64_t sequence = 0;  ///< number of swaps, from 0
  int pattern = 0;
  std::chrono::steady_clock::time_point time;  ///< this machine's clock, once shown
  double seconds = 0;                          ///< since the first
};

/// How to show patterns in a loop.
struct ProjectionSettings {
  double refresh_hz = 60;  ///< the projector's, see MonitorSink::refresh_hz
  int hold = 1;            ///< projector refreshes per pattern
  std::function<void(const PatternSwap&)> on_swap = {};
  std::function<bool()> ends = {};  ///< called after each refresh
};

/// Statistics of a shown sequence.
struct ProjectionReport {
  std::uint64_t shown = 0;  ///< patterns
  /// Refreshes with a pattern: `hold` each, 1 or more for the last.
  std::uint64_t refreshes = 0;
  std::uint64_t late = 0;  ///< patterns more than half a refresh late
  double seconds = 0;      ///< from the first pattern to the last
  /// Whether show() waits for the projector's refresh; otherwise patterns are timed by the clock.
  bool waits_for_refresh = true;
};

/// Loops through the `count` patterns loaded in `sink` until `ends` returns true. Throws like the
/// sink, and Error if `hold` is below 1, the rate is not positive or there are no patterns.
ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings);

/// Refreshes per pattern: `hold`, or `refresh_hz` divided by `rate` (patterns per second); default
/// 1. Throws Error if both are given, if `hold` is below 1, if the rate is not refresh_hz divided
/// by a whole number within 2 %, or if refresh_hz is 0 (unknown).
int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz);

}  // namespace slipstream::monitor
