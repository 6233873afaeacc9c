#include "slipstream/frames/rolling_window.h"

#include <limits>
#include <utility>

namespace slipstream {

RollingWindow::RollingWindow(int frames, int cycle)
    : count_(static_cast<std::uint64_t>(frames)),
      cycle_(static_cast<std::uint64_t>(cycle)),
      ring_(2 * count_) {}

void RollingWindow::begin_at(std::uint64_t position) {
  begun_ = true;
  newest_ = position;
  next_ = position + count_ - 1;
}

bool RollingWindow::put(std::uint64_t position, Pooled<Frame> frame) {
  if (position > std::numeric_limits<std::uint64_t>::max() / 2) return false;  // sums would wrap
  if (!begun_) begin_at(position);
  if (position + count_ - 1 < next_ || has(position)) return false;
  at(position) = {position, std::move(frame)};
  if (position <= newest_) return true;
  newest_ = position;
  // What the windows up to here still lack is N places back or more.
  if (position >= next_ + count_) {
    const std::uint64_t waited_for = position - count_ + 1;
    lost_ += waited_for - next_;
    next_ = waited_for;
  }
  return true;
}

bool RollingWindow::whole() {
  for (std::uint64_t back = 0; back < count_; ++back) {
    if (!has(next_ - back)) return false;
  }
  return true;
}

bool RollingWindow::next(std::vector<Pooled<Frame>>& window) {
  while (begun_ && next_ <= newest_) {
    std::uint64_t first = next_ + 1 - count_;
    if (whole()) {
      window.resize(count_);
      const std::uint64_t begin = count_ == cycle_ ? 0 : first;
      first_pattern_ = static_cast<int>(begin % cycle_);
      for (; first <= next_; ++first) window[(first - begin) % count_] = at(first).frame;
      ++next_;
      return true;
    }
    // A gap that is waited for keeps back only windows that contain it.
    std::optional<std::uint64_t> given_up;
    for (; first <= next_ && first + count_ <= newest_; ++first) {
      if (!has(first)) given_up = first;
    }
    if (!given_up) return false;
    lost_ += *given_up + count_ - next_;
    next_ = *given_up + count_;
  }
  return false;
}

void RollingWindow::restart(std::uint64_t first) {
  if (!begun_) return;
  if (first + count_ > next_ + 1) lost_ += first + count_ - 1 - next_;
  for (Place& place : ring_) place = {};
  begun_ = false;
}

}  // namespace slipstream
