#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/devices/gamma_table.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/view/resource.h"
#include "slipstream/view/shader_program.h"
#include "slipstream/view/window.h"

namespace slipstream::monitor {

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

}  // namespace slipstream::monitor
