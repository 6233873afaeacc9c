#include "slipstream/frames/frame_views.h"

#include <cstddef>

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

}  // namespace slipstream
