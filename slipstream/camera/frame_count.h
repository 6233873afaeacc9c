#pragma once

#include <cstdint>
#include <optional>

namespace slipstream {

/// Turns a camera's frame numbers into a count that never wraps. GigE Vision counts 1 to 65535 and
/// then from 1 again (no frame is numbered 0); its extended numbers and USB3 Vision have 64 bits.
class FrameCount {
 public:
  /// `cycle`: patterns in a scan. After an interruption the count goes on at a multiple of it and
  /// leaves at least one out, so that the pattern is still the count modulo `cycle` and no scan is
  /// put together from before and after.
  explicit FrameCount(int cycle) : cycle_(static_cast<std::uint64_t>(cycle)) {}

  /// The camera begins: its frame `first` shows the first pattern.
  void begin(std::uint64_t first) {
    if (newest_) start_ = (*newest_ + 1 + cycle_) / cycle_ * cycle_;
    first_ = last_ = first;
    unwrapped_ = 0;
  }

  /// The count of the frame with that number. A camera that begins anew without a word is noticed
  /// where its numbers fall far back.
  std::uint64_t operator()(std::uint64_t number) {
    constexpr std::int64_t round = 65535, far = 1000;
    auto step = static_cast<std::int64_t>(number - last_);
    if (number <= round && last_ <= round) {
      if (step < -round / 2)
        step += round;
      else if (step > round / 2 && unwrapped_ > round / 2)
        step -= round;
    }
    if (step < -far || unwrapped_ + step < 0) {
      begin(number < first_ + far ? first_ : number);
      step = static_cast<std::int64_t>(number - last_);
    }
    unwrapped_ += step;
    last_ = number;
    const std::uint64_t count = start_ + static_cast<std::uint64_t>(unwrapped_);
    if (!newest_ || count > *newest_) newest_ = count;
    return count;
  }

  /// The count of the frame that begin() named.
  [[nodiscard]] std::uint64_t start() const { return start_; }

 private:
  std::uint64_t cycle_;
  std::uint64_t start_ = 0;
  std::uint64_t first_ = 0;
  std::uint64_t last_ = 0;
  std::int64_t unwrapped_ = 0;  ///< frames since begin()
  std::optional<std::uint64_t> newest_;
};

}  // namespace slipstream
