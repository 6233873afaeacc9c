#pragma once

#include <string_view>

#include "slipstream/image.h"

// Drawing on RGB pictures. Whatever lies outside the picture is left out. Positions are those of
// pixels' centres; y points down.
namespace slipstream {

using Canvas = Image<Colour>;

struct CanvasPoint {
  double x = 0;
  double y = 0;
};

void fill(Canvas& canvas, const Rectangle& area, Colour colour);

/// A line with round ends, `width` pixels wide, its edges smoothed; a disc if both ends are equal.
void draw_line(Canvas& canvas, CanvasPoint from, CanvasPoint to, double width, Colour colour);

/// One line of text, its capitals 9 to 10 pixels high, with the left end of its baseline at `at`: in
/// DejaVu Sans where Debian's fonts-dejavu-core is installed, otherwise in plain strokes. Bytes that
/// are not printable ASCII become question marks.
void draw_text(Canvas& canvas, std::string_view text, CanvasPoint at, Colour colour);
double text_width(std::string_view text);

/// The picture with each side divided by at least `times`, at least 1: means of blocks of pixels.
Canvas reduced(const Canvas& canvas, double times);

}  // namespace slipstream
