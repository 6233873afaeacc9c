#pragma once

namespace slipstream {

/// Width and height of a picture or of a device's pixel grid.
struct Size {
  int width = 0;
  int height = 0;

  friend bool operator==(const Size&, const Size&) = default;
};

}  // namespace slipstream
