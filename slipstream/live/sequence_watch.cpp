#include "slipstream/live/sequence_watch.h"

#include <algorithm>
#include <utility>

namespace slipstream {

SequenceWatch::Kind SequenceWatch::look(std::uint64_t sequence) {
  const bool restart = begun_ && sequence + memory < expected_;
  if (!begun_ || restart) {
    lost_ += std::exchange(damaged_, 0);
    begun_ = true;
    expected_ = sequence + 1;
    seen_.reset().set(0);
    return restart ? Kind::restart : Kind::fresh;
  }
  if (sequence >= expected_) {
    const std::uint64_t gap = sequence - expected_;
    lost_ += std::max(gap, std::exchange(damaged_, 0));
    seen_ = gap + 1 < memory ? seen_ << (gap + 1) : std::bitset<memory>();
    seen_.set(0);
    expected_ = sequence + 1;
    return Kind::fresh;
  }
  const std::uint64_t back = expected_ - 1 - sequence;
  if (back >= memory || seen_.test(back)) return Kind::repeated;
  seen_.set(back);
  if (lost_ > 0) --lost_;
  return Kind::fresh;
}

}  // namespace slipstream
