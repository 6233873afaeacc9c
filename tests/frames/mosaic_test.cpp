#include "frames/mosaic.h"

#include <array>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::mosaic_test {

/// The index of the colour, red first, at a pixel of a mosaic whose first two rows are `filters`.
std::size_t colour_at(const std::string& filters, int column, int row) {
  return std::string("RGB").find(filters[static_cast<std::size_t>(2 * (row % 2) + column % 2)]);
}

/// What a sensor with that mosaic sees.
template <class Light>
Image<std::uint16_t> seen(const std::string& filters, Size size, const Light& light) {
  Image<std::uint16_t> raw(size);
  for_each_pixel_in_order(size, [&](int column, int row) {
    raw(column, row) =
        static_cast<std::uint16_t>(light(colour_at(filters, column, row), column, row));
  });
  return raw;
}

TEST(MosaicColours, HasANameByItsFirstPixelsOrItsPixelFormat) {
  EXPECT_EQ(mosaic_named("RG"), "RG");
  EXPECT_EQ(mosaic_named("GBRG"), "GB");
  EXPECT_EQ(mosaic_named("BayerBG12p"), "BG");
  for (const char* wrong : {"", "RB", "RGBG", "BayerRG", "Mono8"}) {
    EXPECT_THROW(mosaic_named(wrong), Error) << wrong;
  }
}

TEST(MosaicColours, GivesBackAColourThatChangesEvenly) {
  const auto light = [](std::size_t colour, int column, int row) {
    return std::array{500, 300, 100}[colour] + 8 * column + 4 * row;
  };

  for (const std::string filters : {"RGGB", "GRBG", "GBRG", "BGGR"}) {
    const Size size{13, 10};
    const Image<std::uint16_t> rgb = demosaiced(seen(filters, size, light), mosaic_named(filters));
    for (int row = 1; row + 1 < size.height; ++row) {
      for (int column = 1; column + 1 < size.width; ++column) {
        for (std::size_t colour = 0; colour < 3; ++colour) {
          EXPECT_EQ(rgb(3 * column + static_cast<int>(colour), row), light(colour, column, row))
              << filters;
        }
      }
    }
  }
}

TEST(MosaicColours, IsCompleteAtItsEdges) {
  const auto light = [](std::size_t colour, int, int) { return std::array{9, 5, 7}[colour]; };
  for (const Size size : {Size{2, 2}, Size{3, 5}}) {
    const Image<std::uint16_t> rgb = demosaiced(seen("GRBG", size, light), "GR");
    for_each_pixel_in_order(size, [&](int column, int row) {
      for (std::size_t colour = 0; colour < 3; ++colour) {
        EXPECT_EQ(rgb(3 * column + static_cast<int>(colour), row), light(colour, column, row));
      }
    });
  }
  EXPECT_EQ(demosaiced(Image<std::uint8_t>({1, 1}, 3), "RG").size(), (Size{3, 1}));
}

}  // namespace slipstream::mosaic_test
