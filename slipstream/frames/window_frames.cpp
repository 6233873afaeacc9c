#include "slipstream/frames/window_frames.h"

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

FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra) {
  const int N = window.count() - extra;
  std::vector<int> frames(static_cast<std::size_t>(N));
  for (int n = extra / 2; n < extra / 2 + N; ++n) {
    frames[static_cast<std::size_t>((first_pattern + n) % N)] = n;
  }
  return window.chosen(frames);
}

}  // namespace slipstream
