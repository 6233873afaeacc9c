#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "frames/mosaic.h"
#include "io/file.h"
#include "slipstream/camera.h"
#include "tests/io/expect_error.h"

namespace slipstream::pixel_format_test {

/// Independent, slow packing of each format, pixel by pixel.
std::vector<std::uint8_t> packed(PixelFormat format, const std::vector<std::uint16_t>& pixels) {
  std::vector<std::uint8_t> bytes(bytes_of(format, pixels.size()));
  const auto bits = static_cast<std::size_t>(bits_of(format));
  const auto set_bit = [&](std::size_t at, bool value) {
    if (value) bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | 1U << at % 8);
  };
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t bit = 0; bit < bits; ++bit) {
      const bool value = (pixels[i] >> bit & 1) != 0;
      switch (format) {
        case PixelFormat::mono8:
        case PixelFormat::rgb8:
          set_bit(8 * i + bit, value);
          break;
        case PixelFormat::mono10:
        case PixelFormat::mono12:
        case PixelFormat::mono16:
          set_bit(16 * i + bit, value);
          break;
        case PixelFormat::mono10p:
        case PixelFormat::mono12p:
          set_bit(bits * i + bit, value);
          break;
        case PixelFormat::mjpg:
          break;  // has no bits of pixels
        case PixelFormat::mono10_packed:
        case PixelFormat::mono12_packed:
          const std::size_t pair = i / 2 * 24, second = i % 2;
          const std::size_t low = bits - 8;
          set_bit(bit < low ? pair + 8 + 4 * second + bit : pair + 16 * second + bit - low, value);
      }
    }
  }
  return bytes;
}

TEST(PixelFormat, UnpackEveryFormat) {
  std::mt19937 random(1);
  for (const std::string_view name : pixel_format_names()) {
    const PixelFormat format = pixel_format_named(name);
    EXPECT_EQ(name_of(format), name);
    if (format == PixelFormat::mjpg) continue;  // compressed
    for (const Size size : {Size{1, 1}, Size{5, 3}, Size{16, 4}, Size{7, 1}}) {
      Frame frame({size, bits_of(format)});
      std::vector<std::uint16_t> pixels;
      for (int i = 0; i < size.width * size.height; ++i) {
        pixels.push_back(static_cast<std::uint16_t>(random() % (1U << bits_of(format))));
      }
      const std::vector<std::uint8_t> bytes = packed(format, pixels);
      ASSERT_TRUE(unpack(format, bytes, frame)) << name;
      std::visit(
          [&](const auto& image) {
            EXPECT_TRUE(std::equal(image.begin(), image.end(), pixels.begin())) << name;
          },
          frame.pixels);
      EXPECT_FALSE(unpack(format, std::span(bytes).first(bytes.size() - 1), frame)) << name;
    }
  }
}

TEST(PixelFormat, AMosaicIsAnyOfGrey) {
  CameraSettings settings;
  for (const char* name : {"BayerRG8", "BayerGR10", "BayerGB12p", "BayerBG12Packed", "Mono12p"}) {
    set_pixel_format(settings, name);
    EXPECT_EQ(pixel_format_of(settings), name);
  }
  EXPECT_EQ(settings.mosaic, "");
  for (const char* name : {"Bayer8", "BayerRG", "BayerRGB8", "BayerRR8", "BayerRG9", "BayerRG11"}) {
    expect_error([&] { set_pixel_format(settings, name); }, {"BayerRG8"});
  }
}

/// A mosaic that sees `light` of column and row with these gains of red, green and blue.
template <class Light>
Frame mosaic_of(const FrameFormat& format, std::string_view order, const Light& light) {
  const std::string filters = order == "RG"   ? "RGGB"
                              : order == "GR" ? "GRBG"
                              : order == "GB" ? "GBRG"
                                              : "BGGR";
  Frame frame(format);
  std::visit(
      [&](auto& image) {
        for (int row = 0; row < image.height(); ++row) {
          for (int column = 0; column < image.width(); ++column) {
            const char filter = filters[static_cast<std::size_t>(2 * (row % 2) + column % 2)];
            const double gain = filter == 'R' ? 0.6 : filter == 'G' ? 1 : 0.4;
            image(column, row) = static_cast<std::remove_cvref_t<decltype(image(0, 0))>>(
                std::lround(gain * light(column, row)));
          }
        }
      },
      frame.pixels);
  return frame;
}

TEST(PixelFormat, MosaicGivesEachColourItsShareAtEveryPixel) {
  for (const char* order : {"RG", "GR", "GB", "BG"}) {
    for (const FrameFormat& format : {FrameFormat{{9, 6}, 8}, FrameFormat{{6, 5}, 12}}) {
      Frame frame = mosaic_of(format, order, [](int, int) { return 200.0; });
      make_grey(frame);
      std::visit(
          [](const auto& image) {
            for (const auto pixel : image) EXPECT_EQ(pixel, (120 + 2 * 200 + 80) / 4);
          },
          frame.pixels);
    }
  }
  for (const Size size : {Size{1, 1}, Size{1, 3}, Size{3, 1}, Size{2, 2}}) {
    Frame frame = mosaic_of({size, 8}, "RG", [](int, int) { return 100.0; });
    make_grey(frame);
    EXPECT_GE(std::get<0>(frame.pixels)(0, 0), 60);
  }
}

TEST(PixelFormat, MosaicLeavesThePhaseInPlace) {
  constexpr int steps = 4;
  const auto phase = [](int column, int row) { return 0.35 * column + 0.1 * row; };
  std::vector<Frame> frames;
  for (int n = 0; n < steps; ++n) {
    frames.push_back(mosaic_of({{40, 30}, 12}, "GB", [&](int column, int row) {
      return 2000 + 1500 * std::cos(phase(column, row) - n * std::numbers::pi / 2);
    }));
    make_grey(frames.back());
  }
  const auto at = [&](int n, int column, int row) {
    return static_cast<double>(
        std::get<1>(frames[static_cast<std::size_t>(n)].pixels)(column, row));
  };
  for (int row = 1; row < 29; ++row) {
    for (int column = 1; column < 39; ++column) {
      const double found = std::atan2(at(1, column, row) - at(3, column, row),
                                      at(0, column, row) - at(2, column, row));
      EXPECT_NEAR(std::remainder(found - phase(column, row), 2 * std::numbers::pi), 0, 0.001);
    }
  }
}

TEST(PixelFormat, MosaicASaturatedColourSaturatesThePixel) {
  Frame frame(FrameFormat{{5, 5}, 8});
  std::get<0>(frame.pixels)(2, 2) = 255;
  make_grey(frame);
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 5; ++column) {
      const bool near = std::abs(row - 2) <= 1 && std::abs(column - 2) <= 1;
      EXPECT_EQ(std::get<0>(frame.pixels)(column, row), near ? 255 : 0);
    }
  }
}

TEST(PixelFormat, OtherNamesAreRefused) {
  expect_error([] { (void)pixel_format_named("BGR8"); }, {"BGR8", "Mono12p", "RGB8"});
}

}  // namespace slipstream::pixel_format_test
