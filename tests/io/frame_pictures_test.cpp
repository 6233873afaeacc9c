#include "io/frame_pictures.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tiffio.h>

#include "io/image_file.h"
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

}  // namespace slipstream::frame_pictures_test
