#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

namespace slipstream {

/// The numbers that a text as "2,0,1" says, with that mark between each and the next; empty for any
/// other text.
template <class Number>
std::vector<Number> numbers_in(std::string_view text, char mark) {
  std::vector<Number> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    Number number{};
    const auto [after, failure] = std::from_chars(at, end, number);
    if (failure != std::errc()) return {};
    numbers.push_back(number);
    if (after == end) return numbers;
    if (*after != mark) return {};
    at = after + 1;
  }
}

/// The number that a text says; none for any other text.
template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [after, failure] = std::from_chars(text.data(), end, number);
  return failure == std::errc() && after == end ? std::optional(number) : std::nullopt;
}

}  // namespace slipstream
