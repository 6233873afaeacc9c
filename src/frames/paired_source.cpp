#include "frames/paired_source.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "base/throw_if-inl.h"

namespace slipstream {

PairedSource::PairedSource(std::unique_ptr<FrameSource> first, std::unique_ptr<FrameSource> second)
    : SourceOver(std::move(first)),
      second_(std::move(second)),
      held_first_(source_->format()),
      held_second_(second_->format()) {
  const int bits = source_->format().bits, other = second_->format().bits;
  throw_if(bits != other, "the first camera gives {} bits, the second {}; both must agree", bits,
           other);
}

void PairedSource::start() {
  has_first_ = has_second_ = false;
  second_->start();
  source_->start();
}

void PairedSource::stop() {
  source_->stop();
  second_->stop();
}

void PairedSource::trigger() {
  source_->trigger();
  second_->trigger();
}

Arrival PairedSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;

  while (true) {
    // 1. One frame of each camera.
    const auto take = [&](FrameSource& source, Frame& held, bool& has) {
      if (has) return Arrival::frame;
      if (held.format() != source.format()) held = Frame(source.format());
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          end - std::chrono::steady_clock::now());
      const Arrival arrival = source.next(held, std::max(left, std::chrono::milliseconds(0)));
      has = arrival == Arrival::frame;
      return arrival;
    };
    for (const Arrival arrival :
         {take(*source_, held_first_, has_first_), take(*second_, held_second_, has_second_)}) {
      if (arrival != Arrival::frame) return arrival;
    }

    // 2. The older of two numbers has no partner: it is lost, and the gap shows it.
    const std::uint64_t first = held_first_.stamp.sequence, second = held_second_.stamp.sequence;
    if (first != second) {
      (first < second ? has_first_ : has_second_) = false;
      continue;
    }

    // 3. Both are of one pattern.
    has_first_ = has_second_ = false;
    const auto &pattern = held_first_.stamp.pattern_index,
               &other = held_second_.stamp.pattern_index;
    if (pattern && other && *pattern != *other) return Arrival::damaged;

    std::swap(frame.pixels, held_first_.pixels);
    std::swap(frame.second, held_second_.pixels);
    frame.bits = held_first_.bits;
    frame.stamp = held_first_.stamp;
    if (!frame.stamp.pattern_index) frame.stamp.pattern_index = other;
    frame.stamp.host_time = std::max(frame.stamp.host_time, held_second_.stamp.host_time);

    ++paired_;
    return Arrival::frame;
  }
}

SourceCounters PairedSource::counters() const {
  const SourceCounters first = source_->counters(), second = second_->counters();
  return {.delivered = paired_,
          .lost = first.lost + second.lost,
          .resent = first.resent + second.resent,
          .reconnects = first.reconnects + second.reconnects};
}

std::string PairedSource::state() const {
  const std::string first = source_->state();
  return first.empty() ? second_->state() : first;
}

}  // namespace slipstream
