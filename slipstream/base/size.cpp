#include "slipstream/base/size.h"

#include <algorithm>

#include "slipstream/base/numbers.h"

namespace slipstream {

std::optional<Size> size_of_text(std::string_view text) {
  constexpr int largest = 65536;
  const std::vector<int> sides = numbers_in<int>(text, 'x');
  const bool good = sides.size() == 2 && std::min(sides[0], sides[1]) >= 1 &&
                    std::max(sides[0], sides[1]) <= largest;
  return good ? std::optional(Size{sides[0], sides[1]}) : std::nullopt;
}

std::optional<Rectangle> rectangle_of_text(std::string_view text) {
  const std::size_t plus = text.find('+');
  const std::optional<Size> size = size_of_text(text.substr(0, plus));
  if (!size) return std::nullopt;
  if (plus == std::string_view::npos) return Rectangle{.size = *size};
  const std::vector<int> place = numbers_in<int>(text.substr(plus + 1), '+');
  if (place.size() != 2 || place[0] < 0 || place[1] < 0) return std::nullopt;
  return Rectangle{place[0], place[1], *size};
}

}  // namespace slipstream
