#include "io/image_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>
#include <span>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tiffio.h>

#include "io/file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::image_file_test {

namespace fs = std::filesystem;

template <class Pixel>
Image<Pixel> random_image(Size size, int full_scale) {
  std::mt19937 random(3);
  Image<Pixel> image(size);
  for (Pixel& pixel : image)
    pixel = static_cast<Pixel>(random() % static_cast<unsigned>(full_scale + 1));
  return image;
}

/// An OpenCV header over the same pixels.
template <class Pixel>
cv::Mat mat_of(const Image<Pixel>& image) {
  return {image.height(), image.width(), cv::traits::Type<Pixel>::value,
          const_cast<Pixel*>(image.begin())};
}

TEST(ImageFile, FramesComeBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  for (const char* ending : {"png", "tiff", "bmp", "pgm"}) {
    const auto path = folder.path() / (std::string("frame.") + ending);
    const auto image = random_image<std::uint8_t>({33, 17}, 255);
    write_frames({path}, FrameSet(FrameSet::Images8{image}));
    const LoadedFrames loaded = read_frames({path});
    EXPECT_TRUE(loaded.warnings.empty());
    loaded.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
      ASSERT_TRUE((std::is_same_v<Pixel, std::uint8_t>));
      for (int row = 0; row < 17; ++row) {
        for (int column = 0; column < 33; ++column) {
          ASSERT_EQ(frames[0](column, row), image(column, row)) << ending;
        }
      }
    });
  }
}

/// Uses rows that favour different PNG filters.
template <class Pixel>
void expect_read_as_written(Size size, int compression) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "frame.png";
  cv::Mat written(size.height, size.width, CV_MAKETYPE(cv::DataType<Pixel>::depth, 1));
  std::mt19937 random(7);
  for (int row = 0; row < size.height; ++row) {
    const int kind = row / 4 % 4;
    for (int column = 0; column < size.width; ++column) {
      const int slope = kind == 0 ? 0 : kind == 1 ? 90 * row : 70 * column;
      const int noise = kind == 2 ? static_cast<int>(random() % 5) : 0;
      written.at<Pixel>(row, column) =
          static_cast<Pixel>(slope + noise + (kind == 3 ? 60 * row : 0));
    }
  }
  ASSERT_TRUE(cv::imwrite(path, written, {cv::IMWRITE_PNG_COMPRESSION, compression}));
  read_frames({path}).frames.visit([&](const auto& frames) {
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        ASSERT_EQ(frames[0](column, row), written.at<Pixel>(row, column)) << column << ' ' << row;
      }
    }
  });
}

TEST(ImageFile, FramesComeBackWhateverFilterTheirRowsHave) {
  for (const Size size : {Size{1, 1}, Size{1, 40}, Size{61, 40}, Size{640, 64}}) {
    for (const int compression : {0, 1, 6, 9}) {
      expect_read_as_written<std::uint8_t>(size, compression);
      expect_read_as_written<std::uint16_t>(size, compression);
    }
  }
}

TEST(ImageFile, FramesSixteenBitsAndUnquantisedAreExact) {
  const TemporaryFolder folder;
  const auto wide = random_image<std::uint16_t>({20, 10}, 4095);
  write_frames({folder.path() / "wide.png"}, FrameSet(FrameSet::Images16{wide}, 12));
  const FrameSet read_wide = read_frames({folder.path() / "wide.png"}, 12).frames;
  EXPECT_EQ(read_wide.bits(), 12);
  read_wide.visit([&](const auto& frames) { EXPECT_EQ(frames[0](7, 3), wide(7, 3)); });

  Image<double> exact({20, 10}, 0.1);
  exact(4, 5) = M_PI;
  write_frames({folder.path() / "exact.tiff"}, FrameSet(FrameSet::ImagesUnquantised{exact}));
  const FrameSet read_exact = read_frames({folder.path() / "exact.tiff"}).frames;
  EXPECT_FALSE(read_exact.quantised());
  read_exact.visit([&](const auto& frames) { EXPECT_EQ(frames[0](4, 5), M_PI); });
}

TEST(ImageFile, FramesColourIsConvertedWithAWarning) {
  const TemporaryFolder folder;
  const auto path = (folder.path() / "colour.png").string();
  cv::imwrite(path, cv::Mat(8, 8, CV_8UC3, cv::Scalar(90, 90, 90)));
  const LoadedFrames loaded = read_frames({path});
  ASSERT_EQ(loaded.warnings.size(), 1U);
  EXPECT_NE(loaded.warnings[0].find("colour.png"), std::string::npos);
  loaded.frames.visit([](const auto& frames) { EXPECT_EQ(frames[0](3, 3), 90); });
}

TEST(ImageFile, FramesBadOnesAreNamed) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path() / name; };
  write_image(path("good.png"), random_image<std::uint8_t>({64, 48}, 255));
  write_image(path("small.png"), random_image<std::uint8_t>({32, 48}, 255));
  write_image(path("wide.png"), random_image<std::uint16_t>({64, 48}, 65535));
  expect_error([&] { read_frames({path("good.png"), path("none.png")}); }, {"none.png"});
  expect_error(
      [&] {
        read_frames({path("good.png"), path("small.png")});
      },
      {"small.png", "32x48", "64x48"});
  expect_error([&] { read_frames({path("good.png"), path("wide.png")}); }, {"wide.png"});

  const auto bytes = read_file(path("good.png"));
  write_file(path("half.png"), std::span(bytes).first(bytes.size() / 2));
  expect_error([&] { read_frames({path("half.png")}); }, {"half.png", "truncated"});
  auto damaged = bytes;
  damaged[bytes.size() / 2] ^= 1;
  write_file(path("damaged.png"), damaged);
  expect_error([&] { read_frames({path("damaged.png")}); }, {"damaged.png", "incomplete PNG"});
  write_file(path("text.png"), "no picture");
  expect_error([&] { read_frames({path("text.png")}); }, {"text.png"});
  write_file(path("empty.png"), "");
  expect_error([&] { read_frames({path("empty.png")}); }, {"empty.png"});
  write_file(path("jpeg.png"), "\xff\xd8\xff\xe0");
  expect_error([&] { read_frames({path("jpeg.png")}); }, {"jpeg.png", "not a complete JPEG"});
}

/// A file that declares 10000x10000 pixels, but has only some of them.
void write_short_png(const fs::path& path, std::uint8_t bits) {
  write_image(path, random_image<std::uint8_t>({64, 48}, 255));
  std::vector<std::uint8_t> bytes = read_file(path);
  for (const std::size_t side : {16U, 20U}) {  // their two lower bytes
    bytes[side + 2] = 10000 >> 8;
    bytes[side + 3] = 10000 & 255;
  }
  bytes[24] = bits;

  // Its header's checksum, big-endian.
  const std::uint32_t sum = checksum(std::span(bytes).subspan(12, 17));
  for (std::size_t i = 0; i < 4; ++i)
    bytes[29 + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
  write_file(path, bytes);
}

/// A TIFF file of 8 bits to be written.
TIFF* open_tiff(const fs::path& path, int side, int compression) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, side);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, side);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
  return tiff;
}

void write_short_tiff(const fs::path& path, int compression) {
  TIFF* tiff = open_tiff(path, 10000, compression);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5000);
  std::vector<std::uint8_t> line(10000);
  TIFFWriteScanline(tiff, line.data(), 0, 0);
  TIFFClose(tiff);
}

TEST(ImageFile, FramesFileIsLongEnoughForItsPixels) {
  const TemporaryFolder folder;
  const auto png = folder.path() / "short.png", tiff = folder.path() / "short.tiff";
  for (const int bits : {1, 8}) {  // by libpng and without
    write_short_png(png, static_cast<std::uint8_t>(bits));
    expect_error([&] { read_frames({png}); }, {"short.png", "too few for"});
  }

  for (const int compression : {COMPRESSION_NONE, COMPRESSION_PACKBITS, COMPRESSION_LZW}) {
    write_short_tiff(tiff, compression);
    expect_error([&] { read_frames({tiff}); }, {"short.tiff", "too few for"});
  }
}

TEST(ImageFile, FramesTilesReachNotFarBeyondThePicture) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "tiled.tiff";
  for (const int side : {256, 2048}) {
    TIFF* tiff = open_tiff(path, 8, COMPRESSION_LZW);
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, side);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, side);
    std::vector<std::uint8_t> tile(static_cast<std::size_t>(side * side), 7);
    TIFFWriteTile(tiff, tile.data(), 0, 0, 0, 0);
    TIFFClose(tiff);

    if (side == 256) {
      EXPECT_EQ(read_frames({path}).frames.size(), (Size{8, 8}));
    } else {
      expect_error([&] { read_frames({path}); }, {"tiled.tiff", "2048x2048"});
    }
  }
}

TEST(ImageFile, FramesBlackOneIsReadHoweverSmallItsFile) {
  const TemporaryFolder folder;
  for (const char* name : {"black.png", "black.tiff"}) {
    const Image<std::uint8_t> black({2000, 1500});
    write_image(folder.path() / name, black);
    EXPECT_LT(fs::file_size(folder.path() / name), black.pixel_count() / 40);
    EXPECT_EQ(read_frames({folder.path() / name}).frames.size(), black.size());
  }

  // At the best that deflate can do.
  const auto best = folder.path() / "best.png";
  cv::imwrite(best.string(), cv::Mat::zeros(1500, 2000, CV_8UC1), {cv::IMWRITE_PNG_COMPRESSION, 9});
  EXPECT_EQ(read_frames({best}).frames.size(), (Size{2000, 1500}));
}

TEST(ImageFile, FramesPngOfEveryKindComesBackAsOpenCvReadsIt) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "frame.png";
  const auto expect_like_opencv = [&] {
    const cv::Mat expected = cv::imread(path.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
    const LoadedFrames loaded = read_frames({path});
    loaded.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
      ASSERT_EQ(frames[0].width(), expected.cols);
      for (int row = 0; row < expected.rows; ++row) {
        for (int column = 0; column < expected.cols; ++column) {
          const int value = expected.depth() == CV_16U ? expected.at<std::uint16_t>(row, column)
                                                       : expected.at<std::uint8_t>(row, column);
          ASSERT_NEAR(static_cast<double>(frames[0](column, row)), value, 1)
              << column << ' ' << row;
        }
      }
    });
  };
  write_image(path, random_image<std::uint16_t>({33, 17}, 65535));
  expect_like_opencv();
  write_one_bit_image(path, random_image<std::uint8_t>({33, 17}, 1));
  expect_like_opencv();
  for (const int kind : {CV_8UC3, CV_8UC4, CV_16UC3, CV_16UC4}) {
    cv::Mat colours(17, 33, kind);
    cv::randu(colours, 0, 255);
    cv::imwrite(path.string(), colours);
    expect_like_opencv();
  }
}

template <class Pixel>
void expect_pixels(const cv::Mat& expected, const fs::path& path) {
  const LoadedFrames loaded = read_frames({path});
  loaded.frames.visit([&]<class Read>(const Frames<Read>& frames) {
    ASSERT_TRUE((std::is_same_v<Read, Pixel>)) << path;
    ASSERT_EQ(frames[0].width(), expected.cols);
    ASSERT_EQ(frames[0].height(), expected.rows);
    for (int row = 0; row < expected.rows; ++row) {
      for (int column = 0; column < expected.cols; ++column) {
        ASSERT_EQ(frames[0](column, row), expected.at<Pixel>(row, column)) << path;
      }
    }
  });
}

template <class Pixel>
void expect_both_ways(const fs::path& path, const std::vector<int>& settings = {}) {
  const Image<Pixel> image = random_image<Pixel>({33, 17}, std::numeric_limits<Pixel>::max());
  write_image(path, image);
  expect_pixels<Pixel>(cv::imread(path.string(), cv::IMREAD_UNCHANGED), path);
  expect_pixels<Pixel>(mat_of(image), path);
  ASSERT_TRUE(cv::imwrite(path.string(), mat_of(image), settings));
  expect_pixels<Pixel>(mat_of(image), path);
}

TEST(ImageFile, FramesPicturesOfEveryKindGoToOpenCvAndBack) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.tif", "a.bmp", "a.pgm"}) {
    expect_both_ways<std::uint8_t>(folder.path() / name);
  }
  for (const char* name : {"b.png", "b.tiff", "b.pgm"}) {
    expect_both_ways<std::uint16_t>(folder.path() / name);
  }
  for (const int compression : {1, 5, 8, 32773}) {  // none, LZW, deflate, pack bits
    expect_both_ways<std::uint16_t>(folder.path() / "c.tif",
                                    {cv::IMWRITE_TIFF_COMPRESSION, compression});
  }
}

TEST(ImageFile, FramesColoursGoToOpenCvAndBack) {
  const TemporaryFolder folder;
  Image<Colour> image({33, 17});
  for (int i = 0; i < 33; ++i) image(i, 3) = {static_cast<std::uint8_t>(7 * i), 20, 200};
  for (const char* name : {"a.png", "a.tif", "a.bmp"}) {
    const fs::path path = folder.path() / name;
    write_image(path, image);
    const cv::Mat read = cv::imread(path.string(), cv::IMREAD_COLOR);
    EXPECT_EQ(read.at<cv::Vec3b>(3, 10), cv::Vec3b(200, 20, 70)) << name;
    cv::Mat grey;
    cv::cvtColor(read, grey, cv::COLOR_BGR2GRAY);
    expect_pixels<std::uint8_t>(grey, path);
  }
  for (const int kind : {CV_8UC4, CV_16UC3}) {
    cv::Mat colours(17, 33, kind), grey;
    cv::randu(colours, 0, 255);
    const fs::path path = folder.path() / "b.tif";
    ASSERT_TRUE(cv::imwrite(path.string(), colours));
    cv::cvtColor(colours, grey, kind == CV_8UC4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    kind == CV_8UC4 ? expect_pixels<std::uint8_t>(grey, path)
                    : expect_pixels<std::uint16_t>(grey, path);
  }
}

TEST(ImageFile, FramesPgmMayBeText) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frame.pgm";
  write_file(path, "P2\n# by hand\n3 2\n300\n0 1 2\n3 300 5\n");
  expect_pixels<std::uint16_t>((cv::Mat_<std::uint16_t>(2, 3) << 0, 1, 2, 3, 300, 5), path);
  write_file(path, "P2\n3 2\n300\n0 1 2\n3 301 5\n");
  expect_error([&] { read_frames({path}); }, {"frame.pgm", "not a complete PGM"});
  for (const char* levels : {"P5\n3 1\n100\n\x01\x65\x03", "P5\n1 1\n300\n\x02\x03"}) {
    write_file(path, levels);
    expect_error([&] { read_frames({path}); }, {"frame.pgm", "a level above its highest"});
  }
  write_file(path, "P4\n3 2\n\x01\x02");
  expect_error([&] { read_frames({path}); }, {"frame.pgm", "one bit"});
}

TEST(ImageFile, FramesTiledTiffIsReadAndOtherKindsAreNamed) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frame.tif";
  const Image<std::uint8_t> image = random_image<std::uint8_t>({50, 37}, 255);
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  const auto set = [&](std::uint32_t tag, int value) { TIFFSetField(tiff, tag, value); };
  set(TIFFTAG_IMAGEWIDTH, 50);
  set(TIFFTAG_IMAGELENGTH, 37);
  set(TIFFTAG_BITSPERSAMPLE, 8);
  set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  set(TIFFTAG_TILEWIDTH, 16);
  set(TIFFTAG_TILELENGTH, 16);
  for (int y = 0; y < 37; y += 16) {
    for (int x = 0; x < 50; x += 16) {
      std::array<std::uint8_t, 256> tile{};
      for (int i = 0; i < 256; ++i) {
        const int column = x + i % 16, row = y + i / 16;
        if (column < 50 && row < 37) tile[static_cast<std::size_t>(i)] = image(column, row);
      }
      TIFFWriteTile(tiff, tile.data(), static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                    0, 0);
    }
  }
  TIFFClose(tiff);
  expect_pixels<std::uint8_t>(mat_of(image), path);

  tiff = TIFFOpen(path.c_str(), "w");
  set(TIFFTAG_IMAGEWIDTH, 8);
  set(TIFFTAG_IMAGELENGTH, 1);
  set(TIFFTAG_BITSPERSAMPLE, 1);
  set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  std::uint8_t bits = 0x55;
  TIFFWriteScanline(tiff, &bits, 0, 0);
  TIFFClose(tiff);
  expect_error([&] { read_frames({path}); }, {"frame.tif", "unsupported pixel type"});
}

/// Appends numbers, little-endian, to the bytes.
std::string with_numbers(std::string bytes, std::initializer_list<std::uint32_t> numbers) {
  for (const std::uint32_t number : numbers) {
    for (int byte = 0; byte < 4; ++byte) bytes += static_cast<char>(number >> (8 * byte));
  }
  return bytes;
}

std::string png_chunk(const std::string& name, const std::string& data) {
  const std::string checked = name + data;
  std::uint32_t sum = ~0U;
  for (const char byte : checked) {
    sum ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ ((sum & 1) != 0 ? 0xedb88320U : 0U);
  }
  const auto big_endian = [](std::uint32_t number) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
    return bytes;
  };
  return big_endian(static_cast<std::uint32_t>(data.size())) + checked + big_endian(~sum);
}

TEST(ImageFile, FramesLargerThanTheLimitAreRefusedByTheirHeaders) {
  const TemporaryFolder folder;
  const auto expect_refused = [&](const std::string& name, const std::string& bytes) {
    write_file(folder.path() / name, bytes);
    expect_error([&] { read_frames({folder.path() / name}); },
                 {name, "900000000 pixels", "limit 160000000"});
  };
  const std::string sides("\0\0\x75\x30\0\0\x75\x30", 8);  // 30000, big-endian, twice
  const std::string one("\0\0\0\1\0\0\0\1", 8), grey("\x08\0\0\0\0", 5);
  const std::string signature = "\x89PNG\r\n\x1a\n", pixels = png_chunk("IDAT", one);
  expect_refused("frame.png", signature + png_chunk("IHDR", sides + grey) + pixels);
  expect_refused("frame.pgm", "P5\n# some words, 7\n30000 30000\n255\n");
  expect_refused("frame.bmp",
                 with_numbers(std::string("BM") + std::string(12, 'x'),
                              {40, 30000, 0U - 30000U, 1 | 8U << 16, 0, 0, 0, 0, 0, 0}));
  // The size is not at its usual offset.
  expect_refused("late.png",
                 signature + png_chunk("abCd", one) + png_chunk("IHDR", sides + grey) + pixels);

  const std::string tiff("II*\0\x08\0\0\0", 8), eight("\x08\0", 2);
  const auto entry = [](char tag, char type, std::uint32_t value) {
    return with_numbers({tag, 1, type, 0}, {1, value});
  };
  const std::string of_one_byte = entry(2, 3, 8) + entry(6, 3, 1);
  const std::string strips =
      entry(17, 4, 8) + entry(21, 3, 1) + entry(22, 4, 30000) + entry(23, 4, 8);
  expect_refused("frame.tif", tiff + eight + entry(0, 3, 30000) + entry(1, 4, 30000) + of_one_byte +
                                  strips + std::string(4, '\0'));
  expect_refused("tiles.tif", tiff + eight + entry(0, 3, 8) + entry(1, 4, 8) + of_one_byte +
                                  entry(66, 4, 30000) + entry(67, 4, 30000) + entry(68, 4, 8) +
                                  entry(69, 4, 8) + std::string(4, '\0'));
  const std::uint32_t width_at = 8 + 2 + 8 * 12 + 4;
  expect_refused("long.tif", tiff + eight + entry(1, 4, 30000) + of_one_byte + strips +
                                 entry(0, 16, width_at) +
                                 with_numbers(std::string(4, '\0'), {30000, 0}));
}

TEST(ImageFile, FramesOfMoreBytesThanAScanMayHaveAreRefusedBeforeTheyAreDecoded) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frame.pgm";
  write_file(path, "P5\n12000 10000\n255\n");  // header without pixels
  expect_error([&] { read_frames(std::vector<fs::path>(40, path)); },
               {"frame.pgm", "40 frames of 120000000 bytes"});
}

TEST(ImageFile, MapsKeepNanAndThirtyTwoBits) {
  const TemporaryFolder folder;
  Image<double> map({5, 4}, std::numeric_limits<double>::quiet_NaN());
  map(2, 1) = 412.3456789;
  write_map(folder.path() / "map.tiff", map);
  const Image<double> read = read_map(folder.path() / "map.tiff");
  EXPECT_EQ(read(2, 1), static_cast<double>(412.3456789F));
  EXPECT_TRUE(std::isnan(read(0, 0)));
  expect_error([&] { write_map(folder.path() / "map.png", map); }, {"map.png", ".tiff"});
  expect_error(
      [&] {
        write_image(folder.path() / "map.jpg", Image<std::uint8_t>({4, 4}));
      },
      {"map.jpg", ".png"});
}

/// The last four bytes of a TIFF file only say that no other picture follows.
TEST(ImageFile, FramesEveryTruncationOfPixelsIsFound) {
  const TemporaryFolder folder;
  for (const char* name : {"frame.png", "frame.tif", "frame.bmp", "frame.pgm"}) {
    const auto path = folder.path() / name;
    write_image(path, random_image<std::uint8_t>({12, 9}, 255));
    const std::vector<std::uint8_t> whole = read_file(path);
    const std::size_t needed = whole.size() - (path.extension() == ".tif" ? 4 : 0);
    for (std::size_t length = 0; length < needed; ++length) {
      put_bytes(path, std::span(whole).first(length));
      EXPECT_THROW(read_frames({path}), Error) << name << ' ' << length;
    }
  }
}

}  // namespace slipstream::image_file_test
