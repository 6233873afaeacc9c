#include "io/frame_pictures.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include "io/image_file.h"
#include "io/pictures.h"
#include "slipstream/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::frame_pictures_test {

namespace fs = std::filesystem;

/// A picture whose levels rise from left to right.
template <class Pixel>
Image<Pixel> ramp(double step) {
  Image<Pixel> image({20, 3});
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) {
      image(column, row) = static_cast<Pixel>(step * column);
    }
  }
  return image;
}

double level_of(const LoadedFrames& loaded, int column) {
  return loaded.frames.visit(
      [&](const auto& views) { return static_cast<double>(views[0](column, 1)); });
}

template <class Pixel>
void write_with_white_zero(const fs::path& path, const Image<Pixel>& image) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  const auto set = [&](std::uint32_t tag, int value) { TIFFSetField(tiff, tag, value); };
  set(TIFFTAG_IMAGEWIDTH, image.width());
  set(TIFFTAG_IMAGELENGTH, image.height());
  set(TIFFTAG_BITSPERSAMPLE, 8 * int{sizeof(Pixel)});
  set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISWHITE);

  for (int row = 0; row < image.height(); ++row) {
    std::vector<Pixel> line(image.row(row), image.row(row) + image.width());
    for (Pixel& level : line) {
      level = static_cast<Pixel>(std::numeric_limits<Pixel>::max() - level);
    }
    TIFFWriteScanline(tiff, line.data(), static_cast<std::uint32_t>(row), 0);
  }
  TIFFClose(tiff);
}

TEST(FramePictures, InWhichZeroIsWhiteAreInverted) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frame.tif";

  write_with_white_zero(path, ramp<std::uint8_t>(12));
  EXPECT_EQ(level_of(read_frames({path}), 7), 84);

  write_with_white_zero(path, ramp<std::uint16_t>(3000));
  EXPECT_EQ(level_of(read_frames({path}), 7), 21000);
}

TEST(FramePictures, OfRealNumbersHaveTheRangeOfTheCamera) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frame.tiff";
  struct Case {
    double step;
    int bits;
    std::size_t warnings;
  };

  // Levels of 255, shares of 1, and levels of 4095: all show the same.
  for (const auto& [step, bits, warnings] :
       {Case{10, 0, 0}, Case{10.0 / 255, 0, 1}, Case{10.0 * 4095 / 255, 12, 0}}) {
    write_map(path, ramp<float>(step));
    const LoadedFrames loaded = read_frames({path}, bits);

    EXPECT_FALSE(loaded.frames.quantised());
    EXPECT_NEAR(level_of(loaded, 7), 70, 1e-3) << step;
    EXPECT_EQ(loaded.warnings.size(), warnings) << step;
  }
}

/// Three pictures of 40, 120 and 200 grey levels, in that colour, 1 for all of a channel.
std::vector<fs::path> pictures_under(const fs::path& folder, double red, double green,
                                     double blue) {
  std::vector<fs::path> paths;
  for (const int level : {40, 120, 200}) {
    const auto of = [level](double share) { return static_cast<std::uint8_t>(share * level); };
    paths.push_back(folder / fmt::format("frame_{:03}.png", level));
    write_image(paths.back(), Image<Colour>({40, 30}, Colour{of(red), of(green), of(blue)}));
  }
  return paths;
}

TEST(FramePictures, InColourAreReadByTheChannelThatTheLightReaches) {
  const TemporaryFolder folder;

  const LoadedFrames blue = read_frames(pictures_under(folder.path(), 0.05, 0.2, 1));
  EXPECT_EQ(level_of(blue, 7), 40);
  ASSERT_EQ(blue.warnings.size(), 1U) << "one for all pictures";
  EXPECT_NE(blue.warnings.front().find("blue channel"), std::string::npos);

  const LoadedFrames amber = read_frames(pictures_under(folder.path(), 1, 0.2, 0.05));
  EXPECT_EQ(level_of(amber, 7), 40);

  // White light, of a camera whose channels have other gains.
  const LoadedFrames white = read_frames(pictures_under(folder.path(), 1, 0.9, 0.75));
  EXPECT_NEAR(level_of(white, 7), 36.5, 1);
  ASSERT_EQ(white.warnings.size(), 1U);
  EXPECT_NE(white.warnings.front().find("converted to grey"), std::string::npos);
}

TEST(FramePictures, InColourAreReadByTheChosenChannelWithoutAWarning) {
  const TemporaryFolder folder;
  const std::vector<fs::path> paths = pictures_under(folder.path(), 0.5, 1, 0.25);

  const LoadedFrames red = read_frames(paths, 0, grey_channel_named("red"));
  EXPECT_EQ(level_of(red, 7), 20);
  EXPECT_TRUE(red.warnings.empty());
  EXPECT_THROW(grey_channel_named("infrared"), Error);
}

TEST(FramePictures, OfRealNumbersCountAsTheyAreKept) {
  require_readable(largest_picture, 3, 32);
  expect_error([] { require_readable(largest_picture, 4, 32); }, {"4 frames of 1280000000 bytes"});
}

}  // namespace slipstream::frame_pictures_test
