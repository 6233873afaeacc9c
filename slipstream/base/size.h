#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace slipstream {

/// Width and height of a picture or of a device's pixel grid.
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

/// "1824x1140".
inline std::string text_of(Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

/// The size that "1824x1140" says, of 1 to 65536 pixels each way; none for any other text.
std::optional<Size> size_of_text(std::string_view text);

/// A part of a picture or of a sensor: columns from x, rows from y.
struct Rectangle {
  int x = 0;
  int y = 0;
  Size size;
};

/// The rectangle that "640x480+16+8" says, width x height + x + y, or "640x480", which begins at
/// 0, 0; none for any other text.
std::optional<Rectangle> rectangle_of_text(std::string_view text);

}  // namespace slipstream
