#pragma once

#include <cstdint>

namespace slipstream {

/// Turns a camera's frame numbers into a count that never wraps, and tells which are missing. GigE
/// Vision counts 1 to 65535 and then from 1 again (no frame is numbered 0); other cameras have more
/// bits than they can use up.
class FrameCount {
 public:
  /// `cycle`: patterns in a scan, at least 1. After an interruption the count goes on at a multiple
  /// of it and leaves at least one out, so that the pattern is still the count modulo `cycle` and
  /// no scan is put together from before and after.
  explicit FrameCount(int cycle) : cycle_(static_cast<std::uint64_t>(cycle)) {}

  /// The camera begins: its frame `first` shows the first pattern.
  void begin(std::uint64_t first) {
    if (!none_yet_) start_ = (expected_ + cycle_) / cycle_ * cycle_;
    none_yet_ = true;
    first_ = last_ = first;
    unwrapped_ = 0;
  }

  /// The count of the frame with that number. A camera that begins anew without a word is noticed
  /// where its numbers fall far back.
  std::uint64_t operator()(std::uint64_t number) {
    if (step_to(number) < -far || unwrapped_ + step_to(number) < 0) {
      begin(number >= first_ && number < first_ + far ? first_ : number);
    }
    unwrapped_ += step_to(number);
    last_ = number;
    const std::uint64_t count = start_ + static_cast<std::uint64_t>(unwrapped_);
    if (none_yet_) expected_ = count;
    none_yet_ = false;
    if (count >= expected_) {
      missing_ += count - expected_;
      expected_ = count + 1;
    }
    return count;
  }

  /// Counts that were left out because their frames did not come, all in all; those before the
  /// first one after begin() are not among them: the way from the camera is only being set up.
  [[nodiscard]] std::uint64_t missing() const { return missing_; }
  /// Numbers so far from one another are no loss of frames.
  static constexpr int far = 1000;

 private:
  [[nodiscard]] std::int64_t step_to(std::uint64_t number) const {
    constexpr std::int64_t round = 65535;
    const auto step = static_cast<std::int64_t>(number - last_);
    if (number > round || last_ > round) return step;
    if (step < -round / 2) return step + round;
    return step > round / 2 && unwrapped_ > round / 2 ? step - round : step;
  }

  std::uint64_t cycle_;
  std::uint64_t start_ = 0;     ///< the count of frame `first_`
  std::uint64_t expected_ = 0;  ///< one more than the largest count so far
  std::uint64_t missing_ = 0;
  bool none_yet_ = true;  ///< since begin()
  std::uint64_t first_ = 0;
  std::uint64_t last_ = 0;
  std::int64_t unwrapped_ = 0;  ///< frames since begin()
};

}  // namespace slipstream
