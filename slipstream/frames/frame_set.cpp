#include "slipstream/frames/frame_set.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

template <class Pixel>
void require_same_size(const Frames<Pixel>& frames) {
  for (const auto& frame : frames) {
    if (frame.size() != frames.front().size()) {
      throw Error(fmt::format("frame {} is {}x{}, the first {}x{}; all frames have one size",
                              &frame - frames.data(), frame.width(), frame.height(),
                              frames.front().width(), frames.front().height()));
    }
  }
}

/// Calls `body` with every pixel of every frame, and where it is.
template <class Body>
void for_each_level(const FrameViews& frames, const Body& body) {
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for (int row = 0; row < view.height(); ++row) {
        for (int column = 0; column < view.width(); ++column) {
          body(static_cast<double>(view(column, row)), column, row);
        }
      }
    }
  });
}

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

FrameViews::FrameViews(Frames<std::uint8_t> frames) : frames_(std::move(frames)) {
  require_same_size(std::get<Frames<std::uint8_t>>(frames_));
}

FrameViews::FrameViews(Frames<std::uint16_t> frames, int bits)
    : frames_(std::move(frames)), bits_(bits) {
  if (bits < 8 || bits > 16) {
    throw Error(fmt::format("{} bits per camera pixel are out of range; 8 to 16", bits));
  }
  require_same_size(std::get<Frames<std::uint16_t>>(frames_));
}

FrameViews::FrameViews(Frames<double> frames) : frames_(std::move(frames)) {
  require_same_size(std::get<Frames<double>>(frames_));
}

int FrameViews::count() const {
  return visit([](const auto& views) { return static_cast<int>(views.size()); });
}

Size FrameViews::size() const {
  return visit([](const auto& views) { return views.empty() ? Size{} : views.front().size(); });
}

FrameViews FrameViews::chosen(const std::vector<int>& frames) const {
  FrameViews chosen = *this;
  std::visit(
      [&](auto& views) {
        const auto all = views;
        views.clear();
        for (const int n : frames) views.push_back(all[static_cast<std::size_t>(n)]);
      },
      chosen.frames_);
  return chosen;
}

FrameViews FrameViews::part(int first, int count) const {
  return visit([&]<class Pixel>(const Frames<Pixel>& views) {
    FrameViews part;
    part.frames_ = Frames<Pixel>(views.begin() + first, views.begin() + first + count);
    part.bits_ = bits_;
    part.gain_ = gain_;
    return part;
  });
}

Image<std::uint8_t> saturation_mask(const FrameViews& frames) {
  Image<std::uint8_t> mask(frames.size());
  if (!frames.quantised()) return mask;
  for_each_level(frames, [&](double level, int column, int row) {
    if (level >= frames.saturation()) mask(column, row) = 1;
  });
  return mask;
}

Image<std::uint8_t> unclipped_mask(const FrameViews& frames) {
  Image<std::uint8_t> mask(frames.size(), 1);
  for_each_level(frames, [&](double level, int column, int row) {
    if (level <= 0 || (frames.quantised() && level >= frames.saturation())) mask(column, row) = 0;
  });
  return mask;
}

Image<double> weighted_sum(const FrameViews& frames, const std::vector<double>& weights) {
  Image<double> sums(frames.size());
  frames.visit([&](const auto& views) {
    for_each_row(sums.height(), [&](int row) {
      for (std::size_t n = 0; n < weights.size(); ++n) {
        if (weights[n] == 0) continue;
        for (int column = 0; column < sums.width(); ++column) {
          sums(column, row) += weights[n] * static_cast<double>(views[n](column, row));
        }
      }
    });
  });
  return sums;
}

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

void MeanFrames::add(const FrameSet& frames) {
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  if (count_ == 0) {
    bits_ = frames.bits();
    sums_.assign(static_cast<std::size_t>(frames.count()), Image<double>(frames.size()));
    saturated_ = saturated;
  }
  if (frames.count() != static_cast<int>(sums_.size()) || frames.bits() != bits_ ||
      frames.size() != saturated_.size()) {
    throw Error(fmt::format(
        "scan {} has {} frames of {}x{} with {} bits, the first {} of {}x{} with {}; scans that "
        "are averaged are alike",
        count_, frames.count(), frames.size().width, frames.size().height, frames.bits(),
        sums_.size(), saturated_.width(), saturated_.height(), bits_));
  }
  const double grey_level = frames.full_scale() / 255;
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      for (int row = 0; row < views[n].height(); ++row) {
        for (int column = 0; column < views[n].width(); ++column) {
          sums_[n](column, row) += static_cast<double>(views[n](column, row)) / grey_level;
        }
      }
    }
  });
  std::transform(saturated.begin(), saturated.end(), saturated_.begin(), saturated_.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return a | b; });
  ++count_;
}

FrameSet MeanFrames::mean() const {
  FrameSet::ImagesUnquantised means = sums_;
  for (Image<double>& image : means) {
    for (double& intensity : image) intensity /= count_;
  }
  return FrameSet(std::move(means));
}

}  // namespace slipstream
