#include "slipstream/capture/frame_set.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

template <class Pixel>
void require_same_size(const std::vector<Image<Pixel>>& images) {
  for (const Image<Pixel>& image : images) {
    if (image.size() != images.front().size()) {
      throw Error(fmt::format("frame {} is {}x{}, the first {}x{}; all frames have one size",
                              &image - images.data(), image.width(), image.height(),
                              images.front().width(), images.front().height()));
    }
  }
}

}  // namespace

FrameSet::FrameSet(Images8 images) : images_(std::move(images)) {
  require_same_size(std::get<Images8>(images_));
}

FrameSet::FrameSet(Images16 images, int bits) : images_(std::move(images)), bits_(bits) {
  if (bits < 8 || bits > 16) {
    throw Error(fmt::format("{} bits per camera pixel are out of range; 8 to 16", bits));
  }
  require_same_size(std::get<Images16>(images_));
}

FrameSet::FrameSet(ImagesUnquantised images) : images_(std::move(images)) {
  require_same_size(std::get<ImagesUnquantised>(images_));
}

int FrameSet::count() const {
  return std::visit([](const auto& images) { return static_cast<int>(images.size()); }, images_);
}

Size FrameSet::size() const {
  return std::visit(
      [](const auto& images) { return images.empty() ? Size{} : images.front().size(); }, images_);
}

Image<std::uint8_t> saturation_mask(const FrameSet& frames) {
  Image<std::uint8_t> mask(frames.size());
  if (!frames.quantised()) return mask;
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for (int row = 0; row < view.height(); ++row) {
        for (int column = 0; column < view.width(); ++column) {
          if (view(column, row) >= frames.full_scale()) mask(column, row) = 1;
        }
      }
    }
  });
  return mask;
}

}  // namespace slipstream
