#include "app/flag_group.h"

#include <cmath>
#include <cstdlib>

namespace slipstream::app {

std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole) {
  if (text.empty()) return "a number is missing";
  if (is_unsigned && text.find('-') != std::string::npos) return text + " is below 0";
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (*end != '\0') return "'" + text + "' is no number";
  if (!std::isfinite(number)) return text + " is not finite";
  return is_whole && number != std::floor(number) ? text + " is no whole number" : "";
}

}  // namespace slipstream::app
