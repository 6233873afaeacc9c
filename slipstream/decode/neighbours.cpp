#include "slipstream/decode/neighbours.h"

#include <limits>

namespace slipstream {
namespace {

Image<float> transposed(const Image<float>& image) {
  Image<float> turned({image.height(), image.width()});
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) turned(row, column) = image(column, row);
  }
  return turned;
}

}  // namespace

LocatedPixels::LocatedPixels(Size size)
    : coordinate(size, std::numeric_limits<float>::quiet_NaN()), modulation(size) {}

LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames) {
  if (axis == Axis::y) {
    for (Image<float>& frame : frames) frame = transposed(frame);
  }
  LocatedPixels located =
      grid.rows() > 1 ? located_by_symbols(grid, frames.front()) : located_by_stripes(grid, frames);
  if (axis == Axis::y) {
    located.coordinate = transposed(located.coordinate);
    located.modulation = transposed(located.modulation);
  }
  return located;
}

}  // namespace slipstream
