#include "frames/pattern_windows.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <variant>
#include <vector>

#include "base/throw_if-inl.h"
#include "frames/cycle_alignment.h"

namespace slipstream {
namespace {

/// `pictures`: Frame::pixels or Frame::second.
void view(const std::vector<Pooled<Frame>>& window,
          std::variant<Image<std::uint8_t>, Image<std::uint16_t>> Frame::*pictures,
          FrameViews& views) {
  if (window.empty()) {
    views = {};
    return;
  }

  // The first frame has the pixel type of all.
  std::visit(
      [&]<class Pixel>(const Image<Pixel>&) {
        views.assign<Pixel>(window, window.front()->bits, [&](const Pooled<Frame>& frame) {
          return ImageView<const Pixel>(std::get<Image<Pixel>>((*frame).*pictures));
        });
      },
      (*window.front()).*pictures);
}

}  // namespace

void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views) {
  view(window, &Frame::pixels, views);
}

void view_second(const std::vector<Pooled<Frame>>& window, FrameViews& views) {
  view(window, &Frame::second, views);
}

FrameViews views_of(const std::vector<Pooled<Frame>>& window) {
  FrameViews views;
  view_window(window, views);
  return views;
}

FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra) {
  const int N = window.count() - extra;

  std::vector<int> frames(N);
  for (int n = extra / 2; n < extra / 2 + N; ++n) frames[(first_pattern + n) % N] = n;

  return window.chosen(frames);
}

RollingWindow::RollingWindow(int frames, int cycle)
    : count_(frames), cycle_(cycle), ring_(2 * count_) {}

bool RollingWindow::put(std::uint64_t position, Pooled<Frame> frame) {
  if (position > std::numeric_limits<std::uint64_t>::max() / 2) return false;  // would overflow

  if (!std::exchange(begun_, true)) {
    newest_ = position;
    next_ = position + count_ - 1;
  }

  if (position + count_ - 1 < next_ || has(position)) return false;

  at(position) = {position, std::move(frame)};
  if (position <= newest_) return true;

  newest_ = position;
  // Missing frames of windows that end here or earlier are at least N places back.
  if (position >= next_ + count_) {
    const std::uint64_t waited_for = position - count_ + 1;
    lost_ += waited_for - next_;
    next_ = waited_for;
  }
  return true;
}

bool RollingWindow::next(std::vector<Pooled<Frame>>& window) {
  while (begun_ && next_ <= newest_) {
    std::uint64_t first = next_ + 1 - count_;

    const auto places = std::views::iota(first, next_ + 1);

    // A complete window: of one cycle in pattern order, otherwise in frame order.
    if (std::ranges::all_of(places, [&](std::uint64_t place) { return has(place); })) {
      window.resize(count_);
      const std::uint64_t begin = count_ == cycle_ ? 0 : first;
      first_pattern_ = static_cast<int>(begin % cycle_);
      for (; first <= next_; ++first) window[(first - begin) % count_] = at(first).frame;

      ++next_;
      return true;
    }

    // A gap that may still be filled delays only windows that contain it.
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

void RollingWindow::give_up(std::uint64_t last) {
  if (!begun_ || last < next_) return;
  lost_ += last + 1 - next_;
  next_ = last + 1;
}

PatternWindows::PatternWindows(PatternCycle cycle, PatternIndexing indexing, Size size)
    : patterns_(cycle.patterns),
      cycle_(patterns_ + (indexing == PatternIndexing::marker ? 1 : 0)),
      indexing_(indexing),
      sampled_(sample_places(size)),
      alignment_(std::move(cycle.runs)),
      watch_(cycle_, sampled_.size()),
      window_(patterns_ + cycle.extra, patterns_),
      aligned_(indexing != PatternIndexing::marker) {
  recent_.reserve(cycle_);
}

PatternWindows::Place PatternWindows::place_of(std::uint64_t sequence) const {
  // Two cycles ahead, so that a frame can precede the first one.
  const std::uint64_t counted = sequence + (source_offset_ + slipped_) % cycle_ + 2 * cycle_;
  const std::uint64_t index = counted % cycle_;
  return {static_cast<int>(index), counted / cycle_ * patterns_ + index};
}

void PatternWindows::follow_source(const FrameStamp& stamp) {
  if (indexing_ != PatternIndexing::source || !stamp.pattern_index) return;

  // The source's index minus the counted one, modulo the cycle.
  const auto counted = static_cast<int>(stamp.sequence % cycle_);
  const int offset = (*stamp.pattern_index % cycle_ + 2 * cycle_ - counted) % cycle_;
  if (offset == source_offset_) return;

  // The source counts from another place now: windows must not reach back across that.
  if (begun_) {
    window_.restart(place_of(stamp.sequence).position);
    first_ = stamp.sequence;
  }

  source_offset_ = offset;
}

bool PatternWindows::place(const Pooled<Frame>& frame) {
  const Place place = place_of(frame->stamp.sequence);
  return place.index == patterns_ || window_.put(place.position, frame);
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
  // A late frame, or a duplicate.
  if (begun_ && stamp.sequence <= newest_) {
    return aligned_ && stamp.sequence >= first_ && place(frame);
  }

  // The newest frame, kept with the rest of its cycle.
  follow_source(stamp);
  if (!std::exchange(begun_, true)) first_ = stamp.sequence;
  newest_ = stamp.sequence;

  if (std::cmp_equal(recent_.size(), cycle_)) recent_.erase(recent_.begin());
  recent_.push_back(frame);

  sample(*frame, sampled_, samples_);

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

void PatternWindows::finish() {
  if (!begun_) return;
  const Place last = place_of(newest_);
  window_.give_up(last.position - (last.index == patterns_ ? 1 : 0));
}

}  // namespace slipstream
