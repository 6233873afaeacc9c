#include "base/numbers.h"

#include <bit>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace slipstream::numbers_test {

/// Equal bits: tells -0 from 0.
bool is_same(std::optional<double> a, std::optional<double> b) {
  if (!a || !b || std::isnan(*a)) return a.has_value() == b.has_value() && (!a || std::isnan(*b));
  return std::bit_cast<std::uint64_t>(*a) == std::bit_cast<std::uint64_t>(*b);
}

TEST(Numbers, AreReadWithoutFromCharsAsWithIt) {
  // Parts of numbers and of what resembles them.
  const std::vector<std::string> parts{
      "0",   "1",  "7",  "25",  "999999999999",      ".",   "e",   "E", "+", "-", "e-32",
      "e30", "0x", "p1", "inf", "INFINITY",          "nan", "NaN", "(", ")", "a", "_",
      " ",   "\t", ",",  "'",   std::string(1, '\0')};
  std::mt19937_64 random;
  int numbers = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::string text;
    for (auto length = random() % 6; length > 0; --length) text += parts[random() % parts.size()];
    const auto number = number_in<double>(text);
    numbers += number ? 1 : 0;
    ASSERT_TRUE(is_same(number_by_strtod(text), number)) << "'" << text << "'";
  }
  EXPECT_GT(numbers, 10'000);
}

TEST(Numbers, AreReadAsTheyWereWritten) {
  std::mt19937_64 random;
  for (int i = 0; i < 100'000; ++i) {
    const auto number = std::bit_cast<double>(random());
    for (const auto read : {number_in<double>, number_by_strtod}) {
      ASSERT_TRUE(is_same(read(fmt::format("{}", number)), number)) << number;
    }
    const std::string rounded = fmt::format("{:.{}g}", number, 1 + i % 40);
    ASSERT_TRUE(is_same(number_by_strtod(rounded), number_in<double>(rounded))) << rounded;
  }
}

TEST(Numbers, AreReadInEveryLanguage) {
  const char* const comma = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // nullptr: not installed
  for (const auto read : {number_in<double>, number_by_strtod}) {
    for (const char* text : {"1.5", "-0.25e1", ".5", "5.", "1e-310", "inf", "-nan", "00", "-0"}) {
      EXPECT_TRUE(read(text)) << text << (comma ? " with decimal commas" : "");
    }
    for (const char* text : {"", "-", ".", "+1", " 1", "1 ", "1,5", "0x10", "-0X1p1", "1e", "e1",
                             "--1", "1e999", "-1e999", "1e-999", "infinit", "nano", "1.5.2"}) {
      EXPECT_FALSE(read(text)) << text << (comma ? " with decimal commas" : "");
    }
  }
  EXPECT_EQ(number_by_strtod("1.5"), 1.5);
  std::setlocale(LC_NUMERIC, "C");
}

TEST(Numbers, IntegersAreWholeTexts) {
  EXPECT_EQ(number_in<int>("-12"), -12);
  EXPECT_EQ(number_in<int>("1.0"), std::nullopt);
  EXPECT_EQ(number_in<std::uint8_t>("256"), std::nullopt);
}

}  // namespace slipstream::numbers_test
