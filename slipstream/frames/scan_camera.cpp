#include "slipstream/frames/scan_camera.h"

#include <cmath>
#include <type_traits>
#include <utility>

namespace slipstream {
namespace {

template <class Pixel>
bool same_but_for_noise(const Frames<Pixel>& before, const Frames<Pixel>& after,
                        double full_scale) {
  constexpr double noise = 16.0 / 255;
  constexpr std::size_t one_of = 200;
  std::size_t pixels = 0, changed = 0;
  for (std::size_t n = 0; n < before.size(); ++n) {
    for (int row = 0; row < before[n].height(); ++row) {
      const Pixel *a = before[n].row(row), *b = after[n].row(row);
      for (int column = 0; column < before[n].width(); ++column) {
        const double difference = static_cast<double>(a[column]) - static_cast<double>(b[column]);
        changed += std::abs(difference) > noise * full_scale ? 1 : 0;
      }
      pixels += static_cast<std::size_t>(before[n].width());
    }
  }
  return changed * one_of < pixels;
}

}  // namespace

bool is_still(const FrameViews& before, const FrameViews& after) {
  if (before.count() != after.count() || before.size() != after.size() ||
      before.bits() != after.bits()) {
    return false;
  }
  return before.visit([&]<class Pixel>(const Frames<Pixel>& a) {
    return after.visit([&]<class Other>(const Frames<Other>& b) {
      if constexpr (std::is_same_v<Pixel, Other>) {
        return same_but_for_noise(a, b, before.full_scale());
      } else {
        return false;
      }
    });
  });
}

FrameSet frame_set_of(std::vector<Frame> frames) {
  return std::visit(
      [&]<class Pixel>(const Image<Pixel>&) {
        std::vector<Image<Pixel>> images;
        for (Frame& frame : frames) {
          images.push_back(std::move(std::get<Image<Pixel>>(frame.pixels)));
        }
        if constexpr (sizeof(Pixel) == 1) {
          return FrameSet(std::move(images));
        } else {
          return FrameSet(std::move(images), frames.front().bits);
        }
      },
      frames.at(0).pixels);
}

}  // namespace slipstream
