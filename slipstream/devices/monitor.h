#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/window.h"

struct GLFWmonitor;

namespace slipstream::monitor {

/// A monitor's gamma table made the identity, so that grey levels leave the machine as they are; as
/// it was again when this goes, unless the monitor has gone before.
class IdentityGammaTable {
 public:
  IdentityGammaTable(const opengl::WindowSystem& system, int monitor);
  IdentityGammaTable(const IdentityGammaTable&) = delete;
  IdentityGammaTable& operator=(const IdentityGammaTable&) = delete;
  ~IdentityGammaTable();

  /// Whether the monitor has a table at all; one without leaves grey levels alone.
  [[nodiscard]] bool exists() const { return !red_.empty(); }

 private:
  GLFWmonitor* monitor_ = nullptr;
  std::vector<unsigned short> red_, green_, blue_;  ///< as they were
};

/// A projector that is a monitor: it is filled pixel for pixel, without frame or cursor, its gamma
/// table made the identity. In the main thread.
class MonitorSink : public PatternSink {
 public:
  /// `monitor`: number in WindowSystem::monitors. Throws Error for one that is not there,
  /// WorldError where there is no OpenGL.
  MonitorSink(const opengl::WindowSystem& system, int monitor);

  [[nodiscard]] std::optional<Size> size() const override { return size_; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  /// The same for pictures in colour.
  void load_in_colour(std::vector<Image<Colour>> pictures);
  /// Shows pattern n from the monitor's next refresh on, and returns once it has begun, where the
  /// driver waits for it.
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override;

  /// Draws pattern n, not yet to be seen; what is drawn can be read back.
  void draw(std::size_t n) const;
  /// How often the monitor refreshes, as it says; 60 where it does not.
  [[nodiscard]] double refresh_hz() const { return refresh_hz_; }
  /// Whether the monitor has a gamma table that could be set.
  [[nodiscard]] bool has_gamma_table() const { return gamma_table_.exists(); }
  /// Whether Esc was pressed or the window closed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed() const;

 private:
  template <class Pixel>
  void load_all(const std::vector<Image<Pixel>>& patterns);

  int monitor_;
  double refresh_hz_;
  opengl::Window window_;
  IdentityGammaTable gamma_table_;
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
};

/// Which pattern was shown when, as text: "swap,pattern,seconds" and a line for each, the time from
/// the first.
class SwapLog {
 public:
  void add(const PatternSwap& swap);

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_ = "swap,pattern,seconds\n";
  std::optional<std::chrono::steady_clock::time_point> first_;
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

/// How many refreshes a pattern stays: `hold`, or as many as `rate`, patterns per second, leaves of
/// the projector's `refresh_hz`; 1 where neither is given. Throws Error where both are, `hold` is
/// below 1, the rate is not refresh_hz divided by a whole number, to 2 %, or refresh_hz is 0, which
/// stands for unknown.
int refreshes_for(std::optional<double> rate, std::optional<int> hold, double refresh_hz);

}  // namespace slipstream::monitor
