#pragma once

#include <utility>

#include <fmt/ranges.h>

#include "slipstream/error.h"

namespace slipstream {

/// Throws Error with the formatted text if `wrong`.
template <class... Args>
void throw_if(bool wrong, fmt::format_string<Args...> text, Args&&... args) {
  if (wrong) throw Error(fmt::format(text, std::forward<Args>(args)...));
}

}  // namespace slipstream
