#pragma once

#include <optional>
#include <string_view>

#include "slipstream/base/size.h"

namespace slipstream {

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
