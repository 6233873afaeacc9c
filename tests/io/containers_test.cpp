// Frames as other programs store them: pages of a TIFF, PGM of few bits, JPEG.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <tiffio.h>

#include "io/file.h"
#include "io/image_file.h"
#include "io/replay_source.h"
#include "io/result_files.h"
#include "io/scan_folder.h"
#include "io/scan_pictures.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::containers_test {
namespace fs = std::filesystem;

const Scanner scanner = example_scanner({48, 36});
const Sequence four_steps{.strategy = PhaseMeasuring{.steps = 4},
                          .projector = scanner.projector.size};

FrameSet frames_of_bits(int bits, const Sequence& sequence = four_steps) {
  return take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence), {.bits = bits})
      .frames;
}

ScanChanges shown(const Sequence& sequence) {
  return {.sequence = changes_to(sequence)};
}

void expect_same_frames(const FrameSet& a, const FrameSet& b) {
  ASSERT_EQ(a.count(), b.count());
  ASSERT_EQ(a.bits(), b.bits());
  const std::vector<double> places{1, 10, 100, 1000};
  const Image<double> of_a = weighted_sum(a, places), of_b = weighted_sum(b, places);
  for (std::size_t i = 0; i < of_a.pixel_count(); ++i) {
    ASSERT_NEAR(of_a.begin()[i], of_b.begin()[i], 1e-2);
  }
}

struct StackKind {
  const char* mode = "w";  ///< of TIFFOpen: "w8" is BigTIFF, "wb" big-endian
  int compression = COMPRESSION_NONE;
  int pages = 4;
  bool thumbnails = false;  ///< a reduced copy follows each page
  std::string description{};
};

template <class Pixel>
void put_page(TIFF* tiff, const ImageView<const Pixel>& image, const StackKind& kind, int step) {
  const auto set = [&](std::uint32_t tag, int value) { TIFFSetField(tiff, tag, value); };
  set(TIFFTAG_IMAGEWIDTH, image.width() / step);
  set(TIFFTAG_IMAGELENGTH, image.height() / step);
  set(TIFFTAG_BITSPERSAMPLE, 8 * sizeof(Pixel));
  set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  set(TIFFTAG_COMPRESSION, kind.compression);
  set(TIFFTAG_ROWSPERSTRIP, 7);
  if (step > 1) set(TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
  if (!kind.description.empty()) {
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, kind.description.c_str());
  }
  for (int row = 0; row < image.height() / step; ++row) {
    std::vector<Pixel> line;
    for (int column = 0; column < image.width(); column += step) {
      line.push_back(image(column, step * row));
    }
    TIFFWriteScanline(tiff, line.data(), static_cast<std::uint32_t>(row), 0);
  }
  TIFFWriteDirectory(tiff);
}

/// Frames `first` and following as pages of a file.
void write_stack(const fs::path& path, const FrameSet& frames, const StackKind& kind = {},
                 std::size_t first = 0) {
  TIFF* tiff = TIFFOpen(path.c_str(), kind.mode);
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    for (std::size_t n = first; n < first + static_cast<std::size_t>(kind.pages); ++n) {
      put_page(tiff, views[n], kind, 1);
      if (kind.thumbnails) put_page(tiff, views[n], kind, 4);
    }
  });
  TIFFClose(tiff);
}

TEST(Containers, TiffStackIsItsFrames) {
  const TemporaryFolder folder;
  for (const int bits : {8, 16}) {
    const FrameSet frames = frames_of_bits(bits);
    for (const StackKind& kind :
         {StackKind{}, StackKind{.mode = "w8", .compression = COMPRESSION_LZW},
          StackKind{.mode = "wb", .thumbnails = true}}) {
      write_stack(folder.path() / "stack.tif", frames, kind);
      const Scan scan = load_frames(scan_files_in(folder.path(), shown(four_steps)));
      expect_same_frames(scan.frames, frames);
      EXPECT_TRUE(scan.warnings.empty());
    }
  }
}

TEST(Containers, TiffStackMayBeOneOfSeveralFiles) {
  const TemporaryFolder folder;
  const FrameSet frames = frames_of_bits(8);
  write_stack(folder.path() / "part10.TIF", frames, {.pages = 2}, 2);
  write_stack(folder.path() / "part2.tiff", frames, {.pages = 1}, 1);
  write_stack(folder.path() / "part1.tif", frames, {.pages = 1}, 0);
  expect_same_frames(load_frames(scan_files_in(folder.path(), shown(four_steps))).frames, frames);
}

TEST(Containers, TiffStackIsNamedInAScanYaml) {
  const TemporaryFolder folder;
  const FrameSet frames = frames_of_bits(8);
  const fs::path stack = folder.path() / "stack.tif", yaml = folder.path() / "scan.yaml";
  write_stack(stack, frames, {.thumbnails = true});
  for (const auto& named : {std::vector<fs::path>{stack}, with_pages({stack})}) {
    write_scan_files(yaml, {.sequence = four_steps, .frames = named});
    const ScanFiles files = scan_files_in(folder.path());
    EXPECT_EQ(files.frames.size(), 4U);
    EXPECT_EQ(files.frames[1], folder.path() / "stack.tif[2]");
    expect_same_frames(load_frames(files).frames, frames);
    EXPECT_EQ(checksum_of(files), checksum_of_file(yaml, checksum_of_file(stack)));
  }
  DistinctFiles distinct;
  distinct.add_input(folder.path());
  expect_error([&] { distinct.add_output(stack); }, {"stack.tif", "is an input"});
}

TEST(Containers, TiffStackHasWindows) {
  const TemporaryFolder folder;
  const FrameSet frames = frames_of_bits(8);
  write_stack(folder.path() / "a.tif", frames);
  write_stack(folder.path() / "b.tif", reordered(FrameSet(frames), {2, 3, 0, 1}));
  ScanChanges changes = shown(four_steps);
  EXPECT_EQ(window_count(scan_files_in(folder.path(), changes)), 2U);
  ReplaySource replay(folder.path(), {.rate = 0, .loop = false, .scan = changes});
  replay.start();
  Frame frame(replay.format());
  for (int n = 0; n < 8; ++n) ASSERT_EQ(replay.next(frame, {}), Arrival::frame);
  EXPECT_EQ(replay.next(frame, {}), Arrival::ended);
  changes.window = 1;
  for (const char* const order : {"2,3,0,1", "2-3,0-1"}) {
    changes.order = order;
    expect_same_frames(load_frames(scan_files_in(folder.path(), changes)).frames, frames);
  }
  for (const char* const wrong : {"3-2", "0-", "0-1-2", "0-100000", ",0"}) {
    changes.order = wrong;
    EXPECT_THROW((void)scan_files_in(folder.path(), changes), Error) << wrong;
  }
}

TEST(Containers, TiffStackIsListedOnceForAllItsWindows) {
  const TemporaryFolder folder;
  const FrameSet frames = frames_of_bits(8);
  write_stack(folder.path() / "a.tif", frames);
  write_stack(folder.path() / "b.tif", reordered(FrameSet(frames), {2, 3, 0, 1}));

  ScanChanges changes = shown(four_steps);
  changes.folder = std::make_shared<const ListedFolder>(listed_folder(folder.path()));
  EXPECT_EQ(changes.folder->frames.size(), 8U);

  // A picture that comes first later would move the windows.
  write_stack(folder.path() / "0.tif", frames, {.pages = 1}, 3);
  for (const auto& [window, order] : {std::pair{0, ""}, {1, "2,3,0,1"}}) {
    changes.window = window;
    changes.order = order;
    expect_same_frames(load_frames(scan_files_in(folder.path(), changes)).frames, frames);
  }
}

TEST(Containers, TiffStackIsNoSinglePicture) {
  const TemporaryFolder folder;
  const fs::path stack = folder.path() / "stack.tif";
  write_stack(stack, frames_of_bits(8), {.compression = COMPRESSION_LZW, .pages = 3});
  for (const auto& read : {+[](const fs::path& path) { (void)read_levels(path); },
                           +[](const fs::path& path) { (void)read_map(path); },
                           +[](const fs::path& path) { (void)read_frames({path}); }}) {
    expect_error([&] { read(stack); }, {"stack.tif: has 3 pages", "FILE[0]"});
  }
  EXPECT_EQ(read_levels(stack.string() + "[2]").size(), (Size{48, 36}));
  expect_error([&] { (void)read_levels(stack.string() + "[3]"); }, {"stack.tif[3]", "no page 3"});
  expect_error([&] { (void)read_levels(stack.string() + "[-1]"); }, {"stack.tif[-1]"});
  write_file(folder.path() / "a.pgm", "P2\n1 1\n255\n7\n");
  expect_error([&] { (void)read_levels(folder.path() / "a.pgm[0]"); }, {"a.pgm[0]", "not a TIFF"});
}

TEST(Containers, TiffStackIsRefusedIfPagesAreMissing) {
  const TemporaryFolder folder;
  const fs::path stack = folder.path() / "stack.tif";
  const FrameSet frames = frames_of_bits(8);
  write_stack(stack, frames);
  fs::resize_file(stack, fs::file_size(stack) / 2);
  const ScanChanges changes = shown(four_steps);
  expect_error([&] { load_frames(scan_files_in(folder.path(), changes)); }, {"1 frame, "});
  expect_error([&] { (void)read_frames({stack}); }, {"stack.tif", "incomplete TIFF"});
  write_stack(stack, frames, {.pages = 1, .description = "ImageJ=1.53t\nimages=4\nslices=4\n"});
  expect_error([&] { (void)read_frames({stack}); }, {"stack.tif", "ImageJ", "one directory"});
}

/// A frame of 16-bit PGM, as text or binary.
void write_pgm(const fs::path& path, const ImageView<const std::uint16_t>& frame, int highest,
               bool text) {
  std::string bytes = fmt::format("P{}\n# made up\n{} {}\n{}\n", text ? 2 : 5, frame.width(),
                                  frame.height(), highest);
  for_each_pixel_in_order(frame.size(), [&](int column, int row) {
    const std::uint16_t level = frame(column, row);
    if (text) {
      bytes += fmt::format("{}\n", level);
    } else {
      bytes += {static_cast<char>(level >> 8), static_cast<char>(level & 255)};
    }
  });
  write_file(path, bytes);
}

void write_pgms(const fs::path& folder, const FrameSet& frames, int highest, bool text) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      for (std::size_t n = 0; n < views.size(); ++n) {
        write_pgm(folder / fmt::format("{}.pgm", n), views[n], highest, text);
      }
    }
  });
}

TEST(Containers, PgmHighestLevelTellsTheBits) {
  for (const auto& [bits, highest, text] :
       {std::tuple{10, 1023, false}, {12, 4095, true}, {14, 16383, false}, {16, 65535, false}}) {
    const TemporaryFolder folder;
    const FrameSet frames = frames_of_bits(bits);
    write_pgms(folder.path(), frames, highest, text);
    ScanChanges changes = shown(four_steps);
    expect_same_frames(load_frames(scan_files_in(folder.path(), changes)).frames, frames);
    changes.bits = 15;
    EXPECT_EQ(load_frames(scan_files_in(folder.path(), changes)).frames.bits(), 15);
  }
}

TEST(Containers, PgmLargestHighestLevelCounts) {
  const TemporaryFolder folder;
  write_file(folder.path() / "a.pgm", "P2\n1 1\n900\n7\n");
  write_file(folder.path() / "b.pgm", "P2\n1 1\n4000\n7\n");
  EXPECT_EQ(read_frames(images_in_folder(folder.path())).frames.bits(), 12);
  write_file(folder.path() / "c.pgm", std::string("P5\n1 1\n1000\n\x03\xe9", 15));
  expect_error([&] { (void)read_frames({folder.path() / "c.pgm"}); }, {"c.pgm", "level", "1000"});
}

void write_jpegs(const fs::path& folder, const FrameSet& frames, int quality, int channels = 1) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      cv::Mat picture(views[n].height(), views[n].width(), CV_8UC(channels));
      for_each_pixel_in_order(views[n].size(), [&](int column, int row) {
        for (int c = 0; c < channels; ++c) {
          picture.ptr(row, column)[c] = static_cast<std::uint8_t>(views[n](column, row));
        }
      });
      cv::imwrite((folder / fmt::format("{}.{}", n, n % 2 == 0 ? "jpg" : "JPEG")).string(), picture,
                  {cv::IMWRITE_JPEG_QUALITY, quality});
    }
  });
}

TEST(Containers, JpegIsReadWithOneWarning) {
  const FrameSet frames = frames_of_bits(8);
  for (const auto& [quality, channels, most] :
       {std::tuple{100, 1, 1.0}, {90, 3, 6.0}, {50, 1, 20.0}}) {
    const TemporaryFolder folder;
    write_jpegs(folder.path(), frames, quality, channels);
    const Scan scan = load_frames(scan_files_in(folder.path(), shown(four_steps)));
    ASSERT_EQ(scan.warnings.size(), 1U);
    EXPECT_NE(scan.warnings[0].find("4 frames are JPEG"), std::string::npos);
    ASSERT_EQ(scan.frames.count(), 4);
    const Image<double> read = weighted_sum(scan.frames, {1}), taken = weighted_sum(frames, {1});
    double squares = 0;
    for (std::size_t i = 0; i < read.pixel_count(); ++i) {
      squares += std::pow(read.begin()[i] - taken.begin()[i], 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(read.pixel_count())), most) << quality;
  }
}

TEST(Containers, JpegOfCodesNeedsNoWarning) {
  const TemporaryFolder folder;
  const Sequence gray{.strategy = GrayCode{}, .projector = scanner.projector.size};
  write_jpegs(folder.path(), frames_of_bits(8, gray), 80);
  EXPECT_TRUE(load_frames(scan_files_in(folder.path(), shown(gray))).warnings.empty());
}

TEST(Containers, JpegHasNoMoreScansThanTheLimit) {
  const TemporaryFolder folder;
  write_jpegs(folder.path(), frames_of_bits(8), 95);
  const fs::path jpeg = folder.path() / "0.jpg";

  const std::vector<std::uint8_t> whole = read_file(jpeg);
  std::string bytes(whole.begin(), whole.end());
  for (int n = 0; n < 120; ++n) bytes += "\xff\xda";
  write_file(jpeg, bytes);
  expect_error([&] { (void)read_frames({jpeg}); }, {"0.jpg", "121 scans; limit 100"});
}

TEST(Containers, JpegIsNoMapNoColourScanAndNoneBesideOthers) {
  const TemporaryFolder folder;
  const FrameSet frames = frames_of_bits(8);
  write_jpegs(folder.path(), frames, 95);
  const fs::path jpeg = folder.path() / "0.jpg";
  expect_error([&] { (void)read_levels(jpeg); }, {"0.jpg", "JPEG", "PNG"});
  expect_error([&] { (void)read_colour_frames({jpeg}); }, {"0.jpg", "JPEG", "PNG"});
  fs::resize_file(jpeg, fs::file_size(jpeg) / 2);
  expect_error([&] { (void)read_frames({jpeg}); }, {"0.jpg", "not a complete JPEG"});
  write_file(jpeg, "\xff\xd8\xff\xe0");
  expect_error([&] { (void)read_frames({jpeg}); }, {"0.jpg", "not a complete JPEG"});
  write_stack(folder.path() / "stack.tif", frames);
  EXPECT_TRUE(load_frames(scan_files_in(folder.path(), shown(four_steps))).warnings.empty());
}

}  // namespace slipstream::containers_test
