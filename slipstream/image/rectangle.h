#pragma once

#include <optional>
#include <string_view>

#include "slipstream/image/size.h"

namespace slipstream {

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
