#include "slipstream/image/size_text.h"

#include <algorithm>

#include "slipstream/error/number_text.h"

namespace slipstream {

std::optional<Size> size_of_text(std::string_view text) {
  constexpr int largest = 65536;
  const std::vector<int> sides = numbers_in<int>(text, 'x');
  const bool good = sides.size() == 2 && std::min(sides[0], sides[1]) >= 1 &&
                    std::max(sides[0], sides[1]) <= largest;
  return good ? std::optional(Size{sides[0], sides[1]}) : std::nullopt;
}

}  // namespace slipstream
