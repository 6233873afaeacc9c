#include "slipstream/frames/frame_set.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// Throws where the frames do not go together.
template <class Images>
Images checked(Images images, int bits = 8) {
  using Pixel = std::remove_cvref_t<decltype(*images[0].begin())>;
  Frames<Pixel> views(images.begin(), images.end());
  if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
    static_cast<void>(FrameViews(std::move(views), bits));
  } else {
    static_cast<void>(FrameViews(std::move(views)));
  }
  return images;
}

}  // namespace

FrameSet::FrameSet(Images8 images) : images_(checked(std::move(images))) {}

FrameSet::FrameSet(Images16 images, int bits)
    : images_(checked(std::move(images), bits)), bits_(bits) {}

FrameSet::FrameSet(Images16 images, int bits, Image<float> gain)
    : FrameSet(std::move(images), bits) {
  gain_ = std::move(gain);
}

FrameSet::FrameSet(ImagesUnquantised images) : images_(checked(std::move(images))) {}

FrameViews FrameSet::views() const {
  return std::visit(
      [&](const auto& images) {
        using Pixel = std::remove_cvref_t<decltype(*images[0].begin())>;
        FrameViews views;
        views.assign<Pixel>(
            images, bits_, [](const Image<Pixel>& image) { return ImageView<const Pixel>(image); });
        views.set_gain(gain_);
        return views;
      },
      images_);
}

int FrameSet::count() const {
  return std::visit([](const auto& images) { return static_cast<int>(images.size()); }, images_);
}

Size FrameSet::size() const {
  return std::visit(
      [](const auto& images) { return images.empty() ? Size{} : images.front().size(); }, images_);
}

bool is_order_of(const std::vector<int>& order, int count) {
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t n = 0; n < sorted.size(); ++n) {
    if (sorted[n] != static_cast<int>(n)) return false;
  }
  return static_cast<int>(sorted.size()) == count;
}

FrameSet reordered(FrameSet frames, const std::vector<int>& order) {
  if (!is_order_of(order, frames.count())) {
    throw Error(fmt::format("an order of {} frames has each of 0 to {} in it once", frames.count(),
                            frames.count() - 1));
  }
  std::visit(
      [&](auto& images) {
        std::remove_cvref_t<decltype(images)> ordered;
        ordered.reserve(images.size());
        for (const int place : order) {
          ordered.push_back(std::move(images[static_cast<std::size_t>(place)]));
        }
        images = std::move(ordered);
      },
      frames.images_);
  return frames;
}

std::pair<FrameSet, FrameSet> halves(FrameSet frames) {
  FrameSet second;
  second.bits_ = frames.bits_;
  second.gain_ = frames.gain_;
  std::visit(
      [&](auto& images) {
        const auto middle = images.begin() + static_cast<std::ptrdiff_t>(images.size() / 2);
        second.images_ = std::remove_cvref_t<decltype(images)>(std::move_iterator(middle),
                                                               std::move_iterator(images.end()));
        images.erase(middle, images.end());
      },
      frames.images_);
  return {std::move(frames), std::move(second)};
}

}  // namespace slipstream
