#include "slipstream/codes/strategy_settings.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

int whole(double number) {
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max()) {
    throw Error(fmt::format("{} is not a whole number", number));
  }
  return static_cast<int>(number);
}

}  // namespace

SettingValue::SettingValue(const std::vector<double>& numbers)
    : text_(fmt::format("{}", fmt::join(numbers, ","))) {}

std::string SettingValue::text_of(double number) {
  return fmt::format("{}", number);
}

void SettingValue::read(std::vector<double>& values) const {
  values.clear();
  const char* at = text_.data();
  const char* const end = at + text_.size();
  while (true) {
    double number = 0;
    const auto [after, failure] = std::from_chars(at, end, number);
    if (failure != std::errc() || !std::isfinite(number) || (after != end && *after != ',')) {
      throw Error(fmt::format("'{}' is no number, nor numbers with commas between", text_));
    }
    values.push_back(number);
    if (after == end) return;
    at = after + 1;
  }
}

void SettingValue::read(std::vector<int>& values) const {
  std::vector<double> numbers;
  read(numbers);
  values.clear();
  for (const double number : numbers) values.push_back(whole(number));
}

double SettingValue::number() const {
  std::vector<double> numbers;
  read(numbers);
  if (numbers.size() != 1) throw Error(fmt::format("'{}' is not one number", text_));
  return numbers.front();
}

void SettingValue::read(double& value) const {
  value = number();
}

void SettingValue::read(int& value) const {
  value = whole(number());
}

void SettingValue::read(std::string& value) const {
  value = text_;
}

void SettingValue::read(bool& value) const {
  value = text_ == "true" || text_ == "1";
  if (!value && text_ != "false" && text_ != "0") {
    throw Error(fmt::format("'{}' is neither true nor false", text_));
  }
}

}  // namespace slipstream
