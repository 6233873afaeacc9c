#include "slipstream/image/size_text.h"

#include <charconv>

namespace slipstream {

std::optional<Size> size_of_text(std::string_view text) {
  constexpr int largest = 65536;
  Size size;
  const char* const end = text.data() + text.size();
  const auto [middle, bad_width] = std::from_chars(text.data(), end, size.width);
  if (bad_width != std::errc() || middle == end || *middle != 'x') return std::nullopt;
  const auto [rest, bad_height] = std::from_chars(middle + 1, end, size.height);
  const bool good = bad_height == std::errc() && rest == end && size.width >= 1 &&
                    size.height >= 1 && size.width <= largest && size.height <= largest;
  return good ? std::optional(size) : std::nullopt;
}

}  // namespace slipstream
