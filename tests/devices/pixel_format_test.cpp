#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/devices/camera.h"
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

TEST(PixelFormat, OtherNamesAreRefused) {
  expect_error([] { (void)pixel_format_named("BGR8"); }, {"BGR8", "Mono12p", "RGB8"});
}

}  // namespace slipstream::pixel_format_test
