#include "base/numbers.h"

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <string>

// Refuses what std::strtod takes and std::from_chars does not: blanks or a plus sign in front,
// hexadecimal numbers, the decimal point of the program's language, and any characters in "nan()".
std::optional<double> slipstream::number_by_strtod(std::string_view text) {
  // 1. Beginnings that only std::strtod takes.
  const std::string_view amount = text.substr(text.starts_with('-') ? 1 : 0);
  const bool begins = amount.find_first_of("0123456789.iInN") == 0;
  if (!begins || amount.starts_with("0x") || amount.starts_with("0X")) return std::nullopt;

  // 2. Letters, digits and underscores alone between the brackets of "nan()".
  constexpr std::string_view in_nan =
      "0123456789_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
  const std::size_t inside = std::min(amount.find('('), amount.size() - 1) + 1;
  if (amount.find_first_not_of(in_nan, inside) < amount.size() - 1) return std::nullopt;

  // 3. The decimal point of the program's language instead of the dot.
  const std::string point = std::localeconv()->decimal_point;
  std::string local(text);
  if (const std::size_t at = local.find('.'); at != std::string::npos) {
    local.replace(at, 1, point);
  } else if (local.find(point) != std::string::npos) {
    return std::nullopt;
  }

  // 4. The whole text must be the number.
  char* after = nullptr;
  const double number = std::strtod(local.c_str(), &after);
  if (after != local.data() + local.size()) return std::nullopt;

  // 5. Out of range: infinity without "inf", or 0 although a digit is not 0.
  const std::string_view digits = amount.substr(0, amount.find_first_of("eE"));
  const bool is_out_of_range = (number == 0 || std::isinf(number)) &&
                               digits.find_first_of("123456789") != std::string_view::npos;

  return is_out_of_range ? std::nullopt : std::optional(number);
}
