#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/scan.h"
#include "slipstream/strategy.h"

namespace slipstream {

/// Something that goes wrong with a scan.
struct Mistake {
  std::string name;
  std::function<void(Scan&)> make;
  /// One of these stands in the likely cause of a diagnostic.
  std::vector<std::string> causes;
  std::string kind{};
};

using Pictures = std::vector<Image<std::uint8_t>>;

inline Pictures pictures_of(const Scan& scan) {
  Pictures pictures;
  scan.frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      Image<std::uint8_t> picture(view.size());
      for (int row = 0; row < view.height(); ++row) {
        for (int column = 0; column < view.width(); ++column) {
          picture(column, row) = static_cast<std::uint8_t>(view(column, row));
        }
      }
      pictures.push_back(std::move(picture));
    }
  });
  return pictures;
}

/// Frame n is taken from place `order[n]`.
inline auto taken_in_order(std::vector<int> order) {
  return [order](Scan& scan) { scan.frames = reordered(std::move(scan.frames), order); };
}

/// Every pixel of some frames is changed.
inline auto pixels(std::vector<int> frames,
                   std::function<double(double level, int column, int row)> change) {
  return [frames, change](Scan& scan) {
    Pictures pictures = pictures_of(scan);
    for (const int n : frames) {
      Image<std::uint8_t>& picture = pictures[static_cast<std::size_t>(n)];
      for (int row = 0; row < picture.height(); ++row) {
        for (int column = 0; column < picture.width(); ++column) {
          std::uint8_t& level = picture(column, row);
          level = static_cast<std::uint8_t>(
              std::lround(std::clamp(change(level, column, row), 0.0, 255.0)));
        }
      }
    }
    scan.frames = FrameSet(std::move(pictures));
  };
}

inline std::vector<int> all_frames(int count) {
  std::vector<int> frames;
  for (int n = 0; n < count; ++n) frames.push_back(n);
  return frames;
}

/// Frame `to` shows what frame `from` does in the rows from `first` on.
inline auto copied(int from, int to, double first = 0) {
  return [=](Scan& scan) {
    Pictures pictures = pictures_of(scan);
    const Image<std::uint8_t> source = pictures[static_cast<std::size_t>(from)];
    Image<std::uint8_t>& target = pictures[static_cast<std::size_t>(to)];
    for (int row = static_cast<int>(first * source.height()); row < source.height(); ++row) {
      std::copy(source.row(row), source.row(row) + source.width(), target.row(row));
    }
    scan.frames = FrameSet(std::move(pictures));
  };
}

/// All pictures are made anew, each pixel taken from a place of the old ones.
inline auto resampled(
    std::function<std::pair<double, double>(double column, double row, Size)> from,
    double scale = 1) {
  return [=](Scan& scan) {
    Pictures pictures = pictures_of(scan);
    for (Image<std::uint8_t>& picture : pictures) {
      const Size size{static_cast<int>(picture.width() * scale),
                      static_cast<int>(picture.height() * scale)};
      Image<std::uint8_t> made(size);
      for (int row = 0; row < size.height; ++row) {
        for (int column = 0; column < size.width; ++column) {
          const auto [x, y] = from(column, row, picture.size());
          if (x < 0 || y < 0 || x >= picture.width() || y >= picture.height()) continue;
          made(column, row) = picture(static_cast<int>(x), static_cast<int>(y));
        }
      }
      picture = std::move(made);
    }
    scan.frames = FrameSet(std::move(pictures));
    if (scan.scanner) scan.scanner->camera.size = scan.frames.size();
  };
}

inline auto with_setting(std::string name, double value) {
  return [=](Scan& scan) {
    StrategySettings settings = scan.sequence.strategy.settings();
    settings[name] = value;
    scan.sequence.strategy = make_strategy(scan.sequence.strategy.name(), settings);
  };
}

inline auto with_scanner(std::function<void(Scanner&)> change) {
  return [=](Scan& scan) { change(*scan.scanner); };
}

}  // namespace slipstream
