#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace slipstream::app {

/// A bar on stderr that fills as work is done: shown only on a terminal, and only once the work has
/// taken a second. Removed when it goes out of scope.
class Progress {
 public:
  Progress(std::string label, std::int64_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// One more of `total` is done; `already`: before, which says nothing of the rate.
  void advance(bool already = false);

  /// Takes the bar away.
  void finish();

 private:
  void draw() const;

  std::string label_;
  std::int64_t total_;
  std::int64_t done_ = 0, done_before_ = 0;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slipstream::app
