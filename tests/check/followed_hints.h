#pragma once

#include <algorithm>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "slipstream/scan.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"

namespace slipstream {

/// Hints of an advice that a test can follow, e.g. "--order 1,0,2" or "invert them".
inline std::vector<std::string> hints_in(const std::string& advice) {
  static const std::regex hint(
      "(try|set) --[a-z-]+( (?!--)[-0-9.,a-z]+)?( --[a-z-]+( (?!--)[-0-9.,]+)?)*"
      "|the order [0-9,]+ corrects|rotate them by 180|mirror them back|invert them|transpose it"
      "|negate it|swap their matrices, and invert|swap their matrices");
  std::vector<std::string> hints;
  for (auto at = std::sregex_iterator(advice.begin(), advice.end(), hint);
       at != std::sregex_iterator(); ++at) {
    hints.push_back(at->str());
  }
  return hints;
}

inline std::vector<int> numbers_of(const std::string& text) {
  std::vector<int> numbers;
  std::vector<double> values;
  SettingValue(text).read(values);
  for (const double value : values) numbers.push_back(static_cast<int>(value));
  return numbers;
}

inline void set_flag(const std::string& flag, const std::string& value,
                     StrategySettings& settings) {
  std::string name = flag.substr(flag.starts_with("--no-") ? 5 : 2);
  std::ranges::replace(name, '-', '_');
  settings[name] = !value.empty() ? SettingValue(value) : SettingValue(!flag.starts_with("--no-"));
}

/// Follows a hint; false if a test cannot.
inline bool follow(const std::string& hint, Scan& scan) {
  std::vector<std::string> words;
  std::string word;
  for (std::istringstream in(hint); in >> word;) words.push_back(word);
  const auto turn = [&](bool columns, bool rows) {
    resampled([=](double x, double y, Size size) {
      return std::pair(columns ? size.width - 1 - x : x, rows ? size.height - 1 - y : y);
    })(scan);
    return true;
  };
  const auto order = [&](const std::string& text) {
    scan.order = numbers_of(text);
    scan.frames = reordered(std::move(scan.frames), scan.order);
    return true;
  };
  if (words[0] == "the") return order(words[2]);
  if (words[0] == "rotate") return turn(true, true);
  if (words[0] == "mirror") return turn(true, false);
  Scanner* const scanner = scan.scanner ? &*scan.scanner : nullptr;
  const auto invert = [&] {
    scanner->rotation.transposeInPlace();
    scanner->translation = (-scanner->rotation * scanner->translation).eval();
  };
  if (words[0] == "swap") {
    std::swap(scanner->camera.intrinsic, scanner->projector.intrinsic);
    std::swap(scanner->camera.distortion, scanner->projector.distortion);
    if (hint.find("invert") != std::string::npos) invert();
    return true;
  }
  if (words[0] == "invert") return invert(), true;
  if (words[0] == "transpose") return scanner->rotation.transposeInPlace(), true;
  if (words[0] == "negate") return scanner->translation *= -1, true;
  StrategySettings settings = scan.sequence.strategy.settings();
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& flag = words[i];
    const bool valued = i + 1 < words.size() && !words[i + 1].starts_with("--");
    const std::string value = valued ? words[++i] : "";
    if (flag == "--order") return order(value);
    if (flag == "--axis") return scan.sequence.axis = value == "x" ? Axis::x : Axis::y, true;
    if (flag == "--gamma" || flag == "--camera-bits" || flag == "--projector") return false;
    set_flag(flag, value, settings);
  }
  scan.sequence.strategy = make_strategy(scan.sequence.strategy.name(), settings);
  return true;
}

}  // namespace slipstream
