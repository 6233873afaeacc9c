#pragma once

#include <string_view>

namespace slipstream {

/// page.html, as it was when this was built.
std::string_view web_page();

}  // namespace slipstream
