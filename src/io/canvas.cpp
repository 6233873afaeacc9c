#include "io/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <stb_easy_font.h>

namespace slipstream {
namespace {

constexpr double font_scale = 1.4, baseline = 7, stroke = 1.2;

std::string printable(std::string_view text) {
  std::string result(text);
  std::ranges::replace_if(
      result, [](char c) { return c < ' ' || c > '~'; }, '?');
  return result;
}

std::uint8_t between(std::uint8_t from, std::uint8_t to, double share) {
  return static_cast<std::uint8_t>(from + share * (to - from) + 0.5);
}

Colour between(Colour from, Colour to, double share) {
  return {between(from.red, to.red, share), between(from.green, to.green, share),
          between(from.blue, to.blue, share)};
}

}  // namespace

void fill(Canvas& canvas, const Rectangle& area, Colour colour) {
  const int left = std::clamp(area.x, 0, canvas.width());
  const int right = std::clamp(area.x + area.size.width, left, canvas.width());
  const int bottom = std::min(area.y + area.size.height, canvas.height());

  for (int y = std::max(area.y, 0); y < bottom; ++y) {
    std::fill(canvas.row(y) + left, canvas.row(y) + right, colour);
  }
}

void draw_line(Canvas& canvas, CanvasPoint from, CanvasPoint to, double width, Colour colour) {
  const double along_x = to.x - from.x, along_y = to.y - from.y;
  const double squared = along_x * along_x + along_y * along_y;

  // The box around the line, within the canvas.
  const auto first = [&](double a, double b) {
    return std::max(0, static_cast<int>(std::min(a, b) - width));
  };

  const auto last = [&](double a, double b, int end) {
    return std::min(end - 1, static_cast<int>(std::max(a, b) + width) + 1);
  };

  for (int y = first(from.y, to.y); y <= last(from.y, to.y, canvas.height()); ++y) {
    for (int x = first(from.x, to.x); x <= last(from.x, to.x, canvas.width()); ++x) {
      const double dx = x - from.x, dy = y - from.y;

      // The nearest point of the line, from 0 at `from` to 1 at `to`.
      const double nearest =
          squared > 0 ? std::clamp((dx * along_x + dy * along_y) / squared, 0.0, 1.0) : 0;
      const double distance = std::hypot(dx - nearest * along_x, dy - nearest * along_y);

      // The edge is one pixel wide: a pixel's share falls from 1 to 0 across it.
      const double share = std::clamp(0.5 + width / 2 - distance, 0.0, 1.0);
      canvas(x, y) = between(canvas(x, y), colour, share);
    }
  }
}

void draw_text(Canvas& canvas, std::string_view text, CanvasPoint at, Colour colour) {
  // Corners of the bars that make up the letters, clockwise from the upper left.
  struct Corner {
    float x, y, z;
    std::array<unsigned char, 4> colour;
  };
  using Bar = std::array<Corner, 4>;
  constexpr std::size_t most_bars = 32;  // of a letter

  std::vector<Bar> bars(most_bars * text.size());
  bars.resize(stb_easy_font_print(0, 0, printable(text).data(), nullptr, bars.data(),
                                  static_cast<int>(bars.size() * sizeof(Bar))));

  // Bars are one font unit thick: half a unit inwards from its corners, a bar's centre line ends.
  const auto place = [&](const Corner& corner, double inwards) {
    return CanvasPoint{at.x + font_scale * (corner.x + inwards),
                       at.y + font_scale * (corner.y + inwards - baseline)};
  };

  for (const Bar& bar : bars) {
    draw_line(canvas, place(bar[0], 0.5), place(bar[2], -0.5), stroke, colour);
  }
}

double text_width(std::string_view text) {
  return font_scale * stb_easy_font_width(printable(text).data());
}

Canvas reduced(const Canvas& canvas, double times) {
  const auto side = [&](int of) { return std::max(1, static_cast<int>(of / times)); };
  Canvas result({side(canvas.width()), side(canvas.height())});

  // The first row or column of a block; blocks have no gaps and no overlap.
  const auto block = [](int index, int of, int into) {
    return static_cast<int>(static_cast<std::int64_t>(index) * of / into);
  };

  for_each_pixel_in_order(result.size(), [&](int column, int row) {
    std::array<int, 3> sum{};
    int pixels = 0;

    for (int y = block(row, canvas.height(), result.height());
         y < block(row + 1, canvas.height(), result.height()); ++y) {
      for (int x = block(column, canvas.width(), result.width());
           x < block(column + 1, canvas.width(), result.width()); ++x, ++pixels) {
        sum[0] += canvas(x, y).red;
        sum[1] += canvas(x, y).green;
        sum[2] += canvas(x, y).blue;
      }
    }

    const auto mean = [&](int of) { return static_cast<std::uint8_t>((of + pixels / 2) / pixels); };
    result(column, row) = {mean(sum[0]), mean(sum[1]), mean(sum[2])};
  });

  return result;
}

}  // namespace slipstream
