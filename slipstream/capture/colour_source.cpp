#include "slipstream/capture/colour_source.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>

#include "slipstream/capture/colour_channels.h"
#include "slipstream/error/error.h"

namespace slipstream {
namespace {

constexpr int channels = 3;

FrameFormat format_of(const FrameSource& pictures, bool apart) {
  const FrameFormat format = pictures.format();
  if (format.bits != 8 || format.size.width % channels != 0) {
    throw Error("pictures in colour have three values of 8 bits a pixel");
  }
  return {{format.size.width / channels, format.size.height}, apart ? 16 : 8};
}

}  // namespace

ColourSource::ColourSource(std::unique_ptr<FrameSource> pictures,
                           std::optional<ColourMixture> mixture)
    : pictures_(std::move(pictures)),
      mixture_(mixture),
      format_(format_of(*pictures_, mixture.has_value())),
      picture_(pictures_->format()),
      given_(channels) {}

void ColourSource::start() {
  given_ = channels;
  pictures_->start();
}

void ColourSource::take_apart() {
  const auto& values = std::get<Image<std::uint8_t>>(picture_.pixels);
  FrameSet::Images8 seen(channels, Image<std::uint8_t>(format_.size));
  for (std::size_t c = 0; c < seen.size(); ++c) {
    const std::uint8_t* value = values.begin() + c;
    for (std::uint8_t& pixel : seen[c]) {
      pixel = *value;
      value += channels;
    }
  }
  apart_ = FrameSet(std::move(seen));
  if (mixture_) apart_ = unmixed(apart_, *mixture_);
}

Arrival ColourSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  if (given_ == channels) {
    const Arrival arrival = pictures_->next(picture_, timeout);
    if (arrival != Arrival::frame) return arrival;
    take_apart();
    given_ = 0;
  }
  if (frame.format() != format_) frame = Frame(format_);
  std::visit(
      [&]<class Pixel>(Image<Pixel>& image) {
        const auto copy = [&]<class Channel>(const Frames<Channel>& frames) {
          if constexpr (std::is_same_v<Channel, Pixel>) {
            std::copy_n(frames[static_cast<std::size_t>(given_)].row(0), image.pixel_count(),
                        image.begin());
          }
        };
        apart_.visit(copy);
      },
      frame.pixels);
  frame.stamp = picture_.stamp;
  frame.stamp.sequence = channels * frame.stamp.sequence + static_cast<std::uint64_t>(given_);
  if (std::optional<int>& pattern = frame.stamp.pattern_index) {
    *pattern = channels * *pattern + given_;
  }
  ++given_;
  return Arrival::frame;
}

SourceCounters ColourSource::counters() const {
  SourceCounters counters = pictures_->counters();
  counters.delivered *= channels;
  counters.lost *= channels;
  return counters;
}

}  // namespace slipstream
