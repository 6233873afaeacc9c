#include "slipstream/cycle/window_frames.h"

#include <variant>

namespace slipstream {

void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views) {
  if (window.empty()) {
    views = {};
    return;
  }
  std::visit(
      [&]<class Pixel>(const Image<Pixel>&) {
        views.assign<Pixel>(window, window.front()->bits, [](const Pooled<Frame>& frame) {
          return ImageView<const Pixel>(std::get<Image<Pixel>>(frame->pixels));
        });
      },
      window.front()->pixels);
}

FrameViews views_of(const std::vector<Pooled<Frame>>& window) {
  FrameViews views;
  view_window(window, views);
  return views;
}

}  // namespace slipstream
