#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "slipstream/base/colour.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/view/opengl.h"

namespace slipstream::monitor {

/// A monitor as projector: filled pixel for pixel, without frame or cursor. Until the window system
/// ends its gamma table is the identity, so that grey levels are unchanged. In the main thread.
class MonitorSink : public PatternSink {
 public:
  /// `monitor`: in WindowSystem::monitors. Throws Error if missing, WorldError without OpenGL.
  MonitorSink(const opengl::WindowSystem& system, int monitor);

  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  /// The same for pictures in colour.
  void load_in_colour(std::vector<Image<Colour>> pictures);
  /// Shows pattern n from the next refresh on; returns once that began, if the driver waits for it.
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override;

  /// Draws pattern n, not yet to be seen; what is drawn can be read back.
  void draw(std::size_t n) const;
  /// How often the monitor refreshes, as it says; 60 where it does not.
  [[nodiscard]] double refresh_hz() const { return refresh_hz_; }
  /// Whether the monitor has a gamma table that could be set.
  [[nodiscard]] bool has_gamma_table() const { return has_gamma_table_; }
  /// Whether Esc was pressed or the window closed. Answers the desktop meanwhile.
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

/// A pattern that came on the screen: what a camera's frames are matched with.
struct PatternSwap {
  std::uint64_t sequence = 0;  ///< of swaps, from 0
  int pattern = 0;
  std::chrono::steady_clock::time_point time;  ///< of this machine, once it was shown
  double seconds = 0;                          ///< from the first
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
  /// That a pattern was put on for: `hold` each, 1 or more for the last.
  std::uint64_t refreshes = 0;
  std::uint64_t late = 0;  ///< that came more than half a refresh after their time
  double seconds = 0;      ///< from the first to the last
  /// Whether show() waits for the projector's refresh; else patterns went by the clock.
  bool waits_for_refresh = true;
};

/// Shows the `count` patterns that `sink` has loaded in order, over and over, until `ends` says so.
/// Throws as the sink does, Error if `hold` is below 1, the rate not above 0 or no pattern there.
ProjectionReport project_patterns(PatternSink& sink, std::size_t count,
                                  const ProjectionSettings& settings);

/// Refreshes that a pattern stays: `hold`, or what `rate`, patterns per second, leaves of the
/// projector's `refresh_hz`; 1 by default. Throws Error if both are given, `hold` is below 1, the
/// rate is not refresh_hz divided by a whole number, to 2 %, or refresh_hz is 0: unknown.
int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz);

}  // namespace slipstream::monitor
