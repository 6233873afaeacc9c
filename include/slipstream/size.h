#pragma once

#include <string>

namespace slipstream {

/// Width and height of an image or a device's pixel grid.
struct Size {
  int width = 0;
  int height = 0;

  friend bool operator==(const Size&, const Size&) = default;
};

/// Calls `visit(column, row)` for every pixel, row by row.
template <class Visit>
void for_each_pixel_in_order(Size size, const Visit& visit) {
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) visit(column, row);
  }
}

/// Formats a size, e.g. "1824x1140".
inline std::string text_of(Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

/// A rectangle of an image or sensor: columns from x, rows from y.
struct Rectangle {
  int x = 0;
  int y = 0;
  Size size;
};

}  // namespace slipstream
