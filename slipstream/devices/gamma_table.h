#pragma once

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

}  // namespace slipstream::monitor
