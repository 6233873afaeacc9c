#include "io/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <stb_easy_font.h>

#include "base/throw_if-inl.h"
#include "io/file.h"

namespace {

/// Memory for stb_truetype, which would leave letters out without it.
void* memory_or_throw(std::size_t size) {
  void* const memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

#define STBTT_malloc(size, user) (static_cast<void>(user), memory_or_throw(size))
#define STBTT_free(memory, user) (static_cast<void>(user), std::free(memory))
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#include <stb_truetype.h>
#pragma GCC diagnostic pop

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

/// The letters of a TrueType font, at one size.
class OutlineFont {
 public:
  /// Throws Error if the file is not a font.
  explicit OutlineFont(std::vector<std::uint8_t> file) : file_(std::move(file)) {
    throw_if(stbtt_InitFont(&font_, file_.data(), 0) == 0, "not a TrueType font");
    scale_ = stbtt_ScaleForMappingEmToPixels(&font_, 13);
  }

  /// Calls `visit` with each letter and the place of its left end, from 0; returns the width.
  template <class Visit>
  double for_each_letter(const std::string& text, const Visit& visit) const {
    double width = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      visit(text[i], width);

      int advance = 0, bearing = 0;
      stbtt_GetCodepointHMetrics(&font_, text[i], &advance, &bearing);
      if (i + 1 < text.size()) {
        advance += stbtt_GetCodepointKernAdvance(&font_, text[i], text[i + 1]);
      }
      width += static_cast<double>(scale_) * advance;
    }
    return width;
  }

  /// Draws a letter with the left end of its baseline at `at`.
  void draw(Canvas& canvas, char letter, CanvasPoint at, Colour colour) const {
    // 1. The share of each pixel that the letter covers, with the fraction of `at` kept.
    const double left = std::floor(at.x), base = std::floor(at.y + 0.5);
    const auto shift = static_cast<float>(at.x - left);
    int x = 0, y = 0, right = 0, bottom = 0;
    stbtt_GetCodepointBitmapBoxSubpixel(&font_, letter, scale_, scale_, shift, 0, &x, &y, &right,
                                        &bottom);
    const Size size{right - x, bottom - y};
    if (size.width <= 0 || size.height <= 0) return;  // a space

    std::vector<std::uint8_t> shares(static_cast<std::size_t>(size.width) * size.height);
    stbtt_MakeCodepointBitmapSubpixel(&font_, shares.data(), size.width, size.height, size.width,
                                      scale_, scale_, shift, 0, letter);

    // 2. Blend the pixels that lie within the canvas.
    for_each_pixel_in_order(size, [&](int column, int row) {
      const int to_x = static_cast<int>(left) + x + column;
      const int to_y = static_cast<int>(base) + y + row;
      if (to_x < 0 || to_y < 0 || to_x >= canvas.width() || to_y >= canvas.height()) return;

      const double share = shares[static_cast<std::size_t>(row) * size.width + column] / 255.0;
      canvas(to_x, to_y) = between(canvas(to_x, to_y), colour, share);
    });
  }

 private:
  std::vector<std::uint8_t> file_;  // font_ points into it
  stbtt_fontinfo font_{};
  float scale_ = 0;
};

/// The installed font; null if there is none or it cannot be read.
const OutlineFont* installed_font() {
  static const std::unique_ptr<const OutlineFont> font = []() -> std::unique_ptr<OutlineFont> {
    const std::filesystem::path file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    if (!std::filesystem::exists(file)) return nullptr;
    try {
      return std::make_unique<OutlineFont>(read_file(file));
    } catch (const Error&) {
      return nullptr;
    }
  }();
  return font.get();
}

/// Text in the strokes of stb_easy_font.
void draw_strokes(Canvas& canvas, const std::string& text, CanvasPoint at, Colour colour) {
  // Corners of the bars that make up the letters, clockwise from the upper left.
  struct Corner {
    float x, y, z;
    std::array<unsigned char, 4> colour;
  };
  using Bar = std::array<Corner, 4>;
  constexpr std::size_t most_bars = 32;  // of a letter

  std::vector<Bar> bars(most_bars * text.size());
  std::string letters = text;  // stb_easy_font takes them as not const
  bars.resize(stb_easy_font_print(0, 0, letters.data(), nullptr, bars.data(),
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
  const std::string letters = printable(text);
  const OutlineFont* const font = installed_font();
  if (font == nullptr) {
    draw_strokes(canvas, letters, at, colour);
    return;
  }

  font->for_each_letter(letters, [&](char letter, double along) {
    font->draw(canvas, letter, {at.x + along, at.y}, colour);
  });
}

double text_width(std::string_view text) {
  std::string letters = printable(text);
  const OutlineFont* const font = installed_font();
  if (font == nullptr) return font_scale * stb_easy_font_width(letters.data());

  return font->for_each_letter(letters, [](char, double) {});
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
