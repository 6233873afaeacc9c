#include "slipstream/base/error.h"

#include <fmt/format.h>

namespace slipstream {

void require_in_range(bool holds, std::string_view name, double value, std::string_view range) {
  if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
}

}  // namespace slipstream
