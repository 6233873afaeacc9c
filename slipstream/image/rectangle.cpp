#include "slipstream/image/rectangle.h"

#include <charconv>

#include "slipstream/image/size_text.h"

namespace slipstream {

std::optional<Rectangle> rectangle_of_text(std::string_view text) {
  const std::size_t plus = text.find('+');
  const std::optional<Size> size = size_of_text(text.substr(0, plus));
  if (!size) return std::nullopt;
  Rectangle rectangle{.size = *size};
  if (plus == std::string_view::npos) return rectangle;
  const char* const end = text.data() + text.size();
  const auto [middle, bad_x] = std::from_chars(text.data() + plus + 1, end, rectangle.x);
  if (bad_x != std::errc() || middle == end || *middle != '+') return std::nullopt;
  const auto [rest, bad_y] = std::from_chars(middle + 1, end, rectangle.y);
  const bool good = bad_y == std::errc() && rest == end && rectangle.x >= 0 && rectangle.y >= 0;
  return good ? std::optional(rectangle) : std::nullopt;
}

}  // namespace slipstream
