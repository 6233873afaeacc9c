#include "slipstream/frames/pattern_windows.h"

#include <utility>

namespace slipstream {

PatternWindows::PatternWindows(const Sequence& sequence, PatternIndexing indexing, Size size,
                               int scans)
    : patterns_(scans * frame_count(cycle_of(sequence))),
      cycle_(patterns_ + (indexing == PatternIndexing::marker ? 1 : 0)),
      indexing_(indexing),
      grid_(size),
      alignment_(scans == 1 ? sequence.strategy.layout() : Layout{}),
      watch_(cycle_, grid_.count()),
      window_(patterns_ + sequence.motion, patterns_),
      aligned_(indexing != PatternIndexing::marker) {
  recent_.reserve(static_cast<std::size_t>(cycle_));
}

PatternWindows::Place PatternWindows::place_of(std::uint64_t sequence) const {
  const auto cycle = static_cast<std::uint64_t>(cycle_);
  // Two cycles on, so that one frame may be placed before the first of all.
  const std::uint64_t counted =
      sequence + static_cast<std::uint64_t>((told_ + slipped_) % cycle_) + 2 * cycle;
  const std::uint64_t index = counted % cycle;
  return {static_cast<int>(index), counted / cycle * static_cast<std::uint64_t>(patterns_) + index};
}

void PatternWindows::follow_source(const FrameStamp& stamp) {
  if (indexing_ != PatternIndexing::told || !stamp.pattern_index) return;
  const auto counted = static_cast<int>(stamp.sequence % static_cast<std::uint64_t>(cycle_));
  const int told = (*stamp.pattern_index % cycle_ + 2 * cycle_ - counted) % cycle_;
  if (told == told_) return;
  if (begun_) {
    window_.restart(place_of(stamp.sequence).position);
    first_ = stamp.sequence;
  }
  told_ = told;
}

void PatternWindows::remember(const Pooled<Frame>& frame) {
  if (recent_.size() == static_cast<std::size_t>(cycle_)) recent_.erase(recent_.begin());
  recent_.push_back(frame);
}

bool PatternWindows::place(const Pooled<Frame>& frame) {
  const Place place = place_of(frame->stamp.sequence);
  return is_marker(place) || window_.put(place.position, frame);
}

void PatternWindows::move_on(int places) {
  first_ = recent_.front()->stamp.sequence;
  window_.restart(place_of(first_).position);
  slipped_ = (slipped_ + places) % cycle_;
  for (const Pooled<Frame>& frame : recent_) place(frame);
}

std::optional<int> PatternWindows::realignment() {
  if (!watch_.has_cycle()) return std::nullopt;
  if (indexing_ == PatternIndexing::marker) {
    const std::optional<int> places = marker_misalignment(watch_.cycle());
    return places == 0 && aligned_ ? std::nullopt : places;
  }
  const int places = alignment_.misalignment(watch_.cycle());
  return places == 0 ? std::nullopt : std::optional(places);
}

bool PatternWindows::put(const Pooled<Frame>& frame) {
  const FrameStamp& stamp = frame->stamp;
  if (begun_ && stamp.sequence <= newest_) {
    return aligned_ && stamp.sequence >= first_ && place(frame);
  }
  follow_source(stamp);
  if (!std::exchange(begun_, true)) first_ = stamp.sequence;
  newest_ = stamp.sequence;
  remember(frame);
  grid_.sample(*frame, samples_);

  const auto [verdict, slipped] = watch_.look(place_of(stamp.sequence).index, samples_);
  if (verdict == SlipWatch::Verdict::slipping) return true;
  if (verdict == SlipWatch::Verdict::slipped) {
    ++resynchronisations_;
    move_on(slipped);
  } else if (const std::optional<int> places = realignment()) {
    if (std::exchange(aligned_, true)) ++resynchronisations_;
    watch_.move_on(*places);
    move_on(*places);
  } else if (aligned_) {
    place(frame);
  }
  return true;
}

void PatternWindows::restart() {
  window_.restart();
  recent_.clear();
  begun_ = false;
}

}  // namespace slipstream
