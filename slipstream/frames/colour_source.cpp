#include "slipstream/frames/colour_source.h"

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "slipstream/base/error.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/frames/scan_camera.h"

namespace slipstream {
namespace {

FrameFormat format_of(const FrameSource& pictures) {
  const FrameFormat format = pictures.format();
  if (format.bits != 8 || format.size.width % colour_channels != 0) {
    throw Error("pictures in colour have three values of 8 bits a pixel");
  }
  return {{format.size.width / colour_channels, format.size.height}, 8};
}

}  // namespace

ColourSource::ColourSource(std::unique_ptr<FrameSource> pictures)
    : pictures_(std::move(pictures)),
      format_(format_of(*pictures_)),
      picture_(pictures_->format()),
      given_(colour_channels) {}

void ColourSource::start() {
  given_ = colour_channels;
  pictures_->start();
}

Arrival ColourSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  if (given_ == colour_channels) {
    const Arrival arrival = pictures_->next(picture_, timeout);
    if (arrival != Arrival::frame) return arrival;
    given_ = 0;
  }
  if (frame.format() != format_) frame = Frame(format_);
  const std::uint8_t* value = std::get<Image<std::uint8_t>>(picture_.pixels).begin() + given_;
  for (std::uint8_t& pixel : std::get<Image<std::uint8_t>>(frame.pixels)) {
    pixel = *value;
    value += colour_channels;
  }
  frame.stamp = picture_.stamp;
  frame.stamp.sequence =
      colour_channels * frame.stamp.sequence + static_cast<std::uint64_t>(given_);
  if (std::optional<int>& pattern = frame.stamp.pattern_index) {
    *pattern = colour_channels * *pattern + given_;
  }
  ++given_;
  return Arrival::frame;
}

SourceCounters ColourSource::counters() const {
  SourceCounters counters = pictures_->counters();
  counters.delivered *= colour_channels;
  counters.lost *= colour_channels;
  return counters;
}

UnmixedSource::UnmixedSource(std::unique_ptr<FrameSource> source, const ColourMixture& mixture,
                             FrameSet white)
    : channels_(std::move(source)), mixture_(mixture), white_(std::move(white)) {}

void UnmixedSource::start() {
  seen_.clear();
  given_ = stamps_.size();
  channels_->start();
}

Arrival UnmixedSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + timeout;
  while (given_ == stamps_.size()) {
    Frame seen(channels_->format());
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    const Arrival arrival = channels_->next(seen, std::max(left, std::chrono::milliseconds(0)));
    if (arrival != Arrival::frame) return arrival;
    const std::uint64_t number = seen.stamp.sequence;
    if (!seen_.empty() && number != seen_.back().stamp.sequence + 1) seen_.clear();
    if (number % colour_channels != seen_.size()) continue;  // its first one is missing
    seen_.push_back(std::move(seen));
    if (seen_.size() < colour_channels) continue;
    stamps_.clear();
    for (const Frame& channel : seen_) stamps_.push_back(channel.stamp);
    apart_ = unmixed(frame_set_of(std::exchange(seen_, {})), mixture_, white_);
    given_ = 0;
  }
  if (frame.format() != format()) frame = Frame(format());
  apart_.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      auto& image = std::get<Image<std::uint16_t>>(frame.pixels);
      std::copy_n(frames[given_].row(0), image.pixel_count(), image.begin());
    }
  });
  frame.stamp = stamps_[given_++];
  return Arrival::frame;
}

}  // namespace slipstream
