#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slipstream/finding.h"
#include "slipstream/scan.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"

namespace slipstream {

inline std::vector<int> numbers_of(const std::string& text) {
  std::vector<int> numbers;
  std::vector<double> values;
  SettingValue(text).read(values);
  for (const double value : values) numbers.push_back(static_cast<int>(value));
  return numbers;
}

/// Turns the pictures by 180 degrees, or mirrors them left to right.
inline void turn_pictures(Scan& scan, bool rows) {
  resampled([=](double x, double y, Size size) {
    return std::pair(size.width - 1 - x, rows ? size.height - 1 - y : y);
  })(scan);
}

/// Follows a remedy that changes the scanner file or the pictures; false if it is another one.
inline bool follow_by_hand(const Remedy& remedy, Scan& scan) {
  const auto says = [&](std::string_view words) { return remedy.text.starts_with(words); };

  if (says("rotate them by 180")) return turn_pictures(scan, true), true;
  if (says("mirror them back")) return turn_pictures(scan, false), true;
  if (!scan.scanner) return false;

  Scanner& scanner = *scan.scanner;
  const auto invert = [&] {
    scanner.rotation.transposeInPlace();
    scanner.translation = (-scanner.rotation * scanner.translation).eval();
  };

  if (says("swap their matrices")) {
    std::swap(scanner.camera.intrinsic, scanner.projector.intrinsic);
    std::swap(scanner.camera.distortion, scanner.projector.distortion);
    if (says("swap their matrices, and invert")) invert();
  } else if (says("invert them")) {
    invert();
  } else if (says("transpose it")) {
    scanner.rotation.transposeInPlace();
  } else if (says("negate it")) {
    scanner.translation *= -1;
  } else {
    return false;
  }
  return true;
}

/// Follows a remedy; false if a test cannot.
inline bool follow(const Remedy& remedy, Scan& scan) {
  if (remedy.settings.empty()) return follow_by_hand(remedy, scan);

  StrategySettings settings = scan.sequence.strategy.settings();
  for (const auto& [name, value] : remedy.settings) {
    if (name == "gamma" || name == "camera_bits" || name == "projector") return false;

    if (name == "order") {
      scan.order = numbers_of(value);
      scan.frames = reordered(std::move(scan.frames), scan.order);
      return true;
    }
    if (name == "axis") {
      scan.sequence.axis = value == "x" ? Axis::x : Axis::y;
      return true;
    }

    const bool is_switch = value == "true" || value == "false";
    settings[name] = is_switch ? SettingValue(value == "true") : SettingValue(value);
  }

  scan.sequence.strategy = make_strategy(scan.sequence.strategy.name(), settings);
  return true;
}

}  // namespace slipstream
