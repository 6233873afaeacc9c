#include "slipstream/devices/gamma_table.h"

#include <algorithm>
#include <cstddef>

#include <GLFW/glfw3.h>

namespace slipstream::monitor {
namespace {

using Table = std::vector<unsigned short>;

void set_table(GLFWmonitor* monitor, Table& red, Table& green, Table& blue) {
  GLFWgammaramp ramp{red.data(), green.data(), blue.data(), static_cast<unsigned>(red.size())};
  glfwSetGammaRamp(monitor, &ramp);
}

/// GLFW lets go of what it knew of a monitor that was unplugged.
bool is_connected(const GLFWmonitor* monitor) {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  return std::find(monitors, monitors + count, monitor) != monitors + count;
}

}  // namespace

IdentityGammaTable::IdentityGammaTable(const opengl::WindowSystem& system, int monitor) {
  static_cast<void>(system);
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  if (monitor < 0 || monitor >= count) return;
  monitor_ = monitors[monitor];
  const GLFWgammaramp* const ramp = glfwGetGammaRamp(monitor_);
  if (ramp == nullptr || ramp->size < 2) return;
  red_.assign(ramp->red, ramp->red + ramp->size);
  green_.assign(ramp->green, ramp->green + ramp->size);
  blue_.assign(ramp->blue, ramp->blue + ramp->size);
  Table identity(ramp->size);
  for (std::size_t i = 0; i < identity.size(); ++i) {
    identity[i] = static_cast<unsigned short>(65535 * i / (identity.size() - 1));
  }
  Table green = identity, blue = identity;
  set_table(monitor_, identity, green, blue);
}

IdentityGammaTable::~IdentityGammaTable() {
  if (exists() && is_connected(monitor_)) set_table(monitor_, red_, green_, blue_);
}

}  // namespace slipstream::monitor
