#include "app/flag_group.h"

#include <cmath>
#include <cstdlib>

namespace slipstream::app {

std::string why_no_number(const std::string& text, bool is_unsigned) {
  if (text.empty()) return "a number is missing";
  if (is_unsigned && text.find('-') != std::string::npos) return text + " is below 0";
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : text + " is not finite";
}

}  // namespace slipstream::app
