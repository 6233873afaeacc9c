#pragma once

#include <string>

namespace slipstream {

/// Width and height of a picture or of a device's pixel grid.
struct Size {
  int width = 0;
  int height = 0;

  friend bool operator==(const Size&, const Size&) = default;
};

/// "1824x1140".
inline std::string text_of(Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace slipstream
