#pragma once

#include <optional>
#include <string>

#include "slipstream/devices/projection.h"

namespace slipstream::monitor {

/// Which pattern was shown when, as text: "swap,pattern,seconds" and a line for each, the time from
/// the first.
class SwapLog {
 public:
  void add(const PatternSwap& swap);

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_ = "swap,pattern,seconds\n";
  std::optional<std::chrono::steady_clock::time_point> first_;
};

}  // namespace slipstream::monitor
