#pragma once

#include <optional>
#include <string_view>

#include "slipstream/image/size.h"

namespace slipstream {

/// The size that "1824x1140" says, of 1 to 65536 pixels each way; none for any other text.
std::optional<Size> size_of_text(std::string_view text);

}  // namespace slipstream
