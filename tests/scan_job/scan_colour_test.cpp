#include "io/scan_colour.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/image_file.h"
#include "io/scan_folder.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scan_files.h"
#include "slipstream/scan_job.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::scan_colour_test {
namespace fs = std::filesystem;

const Scanner scanner = example_scanner({48, 36});
const Sequence sequence{.strategy = PhaseMeasuring{.steps = 4},
                        .light = {.alpha_p = 200, .beta_p = 30},
                        .projector = scanner.projector.size};

/// The shares of red, green and blue that the scene reflects, in three vertical strips.
std::array<double, 3> paint_at(int column) {
  if (column < 16) return {0.9, 0.5, 0.3};
  if (column < 32) return {0.4, 0.8, 0.6};
  return {0.7, 0.7, 0.7};
}

/// Scan folders of a colour camera that sees a painted sphere.
class ScanColour : public testing::Test {
 protected:
  ScanColour() {
    const VirtualScan grey =
        take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence), {.bits = 8});
    files_ = save_scan(path(), grey.frames, sequence, {.scanner = scanner});
    grey.frames.visit([&](const auto& views) {
      for (const auto& view : views) {
        Image<double>& frame = frames_.emplace_back(view.size());
        for_each_pixel_in_order(view.size(), [&](int column, int row) {
          frame(column, row) = static_cast<double>(view(column, row));
        });
      }
    });
  }

  [[nodiscard]] fs::path path() const { return folder_.path() / "scan"; }

  /// A frame in the colours of the paint.
  [[nodiscard]] Image<Colour> painted(std::size_t n, double brightness = 1) const {
    Image<Colour> picture(scanner.camera.size);
    for_each_pixel_in_order(picture.size(), [&](int column, int row) {
      const auto [red, green, blue] = paint_at(column);
      const double level = brightness * frames_[n](column, row);
      const auto in_8_bits = [](double value) {
        return static_cast<std::uint8_t>(std::min(std::lround(value), 255L));
      };
      picture(column, row) = {in_8_bits(red * level), in_8_bits(green * level),
                              in_8_bits(blue * level)};
    });
    return picture;
  }

  /// Replaces the frames by pictures in colour.
  void paint(double brightness = 1) const {
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      write_image(files_.frames[n], painted(n, brightness));
    }
  }

  /// The mean of the painted frames, which the cloud should have.
  [[nodiscard]] Image<Colour> mean() const {
    Image<Colour> colours(scanner.camera.size);
    std::vector<Image<Colour>> pictures;
    for (std::size_t n = 0; n < frames_.size(); ++n) pictures.push_back(painted(n));

    for_each_pixel_in_order(colours.size(), [&](int column, int row) {
      std::array<int, 3> sums{};
      for (const Image<Colour>& picture : pictures) {
        sums[0] += picture(column, row).red;
        sums[1] += picture(column, row).green;
        sums[2] += picture(column, row).blue;
      }
      const auto rounded = [&](int sum) {
        const int count = static_cast<int>(pictures.size());
        return static_cast<std::uint8_t>((2 * sum + count) / (2 * count));
      };
      colours(column, row) = {rounded(sums[0]), rounded(sums[1]), rounded(sums[2])};
    });
    return colours;
  }

  TemporaryFolder folder_;
  ScanFiles files_;
  std::vector<Image<double>> frames_;
};

void expect_same(const Image<Colour>& colours, const Image<Colour>& expected, int tolerance = 0) {
  ASSERT_EQ(colours.size(), expected.size());
  for (std::size_t i = 0; i < colours.pixel_count(); ++i) {
    ASSERT_NEAR(colours.begin()[i].red, expected.begin()[i].red, tolerance) << i;
    ASSERT_NEAR(colours.begin()[i].green, expected.begin()[i].green, tolerance) << i;
    ASSERT_NEAR(colours.begin()[i].blue, expected.begin()[i].blue, tolerance) << i;
  }
}

TEST_F(ScanColour, OfGreyPicturesIsNone) {
  EXPECT_TRUE(load_scan(path()).colour.empty());
}

TEST_F(ScanColour, IsTheMeanOfTheFramesPixelForPixel) {
  paint();
  expect_same(load_scan(path()).colour, mean());
}

TEST_F(ScanColour, IsOfTheShortestExposureWhereverItStands) {
  Sequence bracket = sequence;
  bracket.exposures = {16, 4, 1};
  std::vector<bool> of_last(12, false);
  std::fill(of_last.begin() + 8, of_last.end(), true);
  EXPECT_EQ(frames_of_colour(bracket), of_last);

  const VirtualScan grey =
      take_scan(scanner, scene_named("sphere", scanner), pattern_set(bracket), {.bits = 8});
  const fs::path folder = folder_.path() / "bracket";
  const ScanFiles files = save_scan(folder, grey.frames, bracket, {.scanner = scanner});
  ASSERT_EQ(files.frames.size(), 12U);
  for (std::size_t i = 0; i < files.frames.size(); ++i) {
    write_image(files.frames[i], painted(i % 4, bracket.exposures[i / 4]));
  }
  expect_same(load_scan(folder).colour, mean());
}

TEST_F(ScanColour, ReachesTheCloud) {
  paint();
  const ScanResult result = reconstruct(load_scan(path()));
  EXPECT_GT(result.counts[0], 100U);
  expect_same(result.cloud.colour, mean());
}

TEST_F(ScanColour, OfARawMosaicIsThatOfItsFilters) {
  for (const std::string filters : {"RGGB", "GBRG"}) {
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      const Image<Colour> picture = painted(n);
      Image<std::uint8_t> raw(picture.size());
      for_each_pixel_in_order(raw.size(), [&](int column, int row) {
        const auto [red, green, blue] = picture(column, row);
        const char filter = filters[static_cast<std::size_t>(2 * (row % 2) + column % 2)];
        raw(column, row) = filter == 'R' ? red : filter == 'G' ? green : blue;
      });
      write_image(files_.frames[n], raw);
    }

    const Scan scan = load_scan(path(), {.mosaic = filters});
    const Image<Colour> expected = mean();
    ASSERT_EQ(scan.colour.size(), expected.size());

    // In the middle of a strip, where neighbours have nearly the same colour.
    for (int row = 12; row < 24; ++row) {
      for (const int column : {8, 24, 40}) {
        EXPECT_NEAR(scan.colour(column, row).red, expected(column, row).red, 12) << filters;
        EXPECT_NEAR(scan.colour(column, row).green, expected(column, row).green, 12);
        EXPECT_NEAR(scan.colour(column, row).blue, expected(column, row).blue, 12);
      }
    }
    EXPECT_GT(reconstruct(scan).counts[0], 100U);
  }
}

TEST_F(ScanColour, MayComeFromWhitePicturesInThreeLights) {
  const Image<Colour> lit = painted(0);
  for (int channel = 0; channel < 3; ++channel) {
    Image<std::uint8_t> picture(lit.size());
    std::ranges::transform(lit, picture.begin(), [&](Colour colour) {
      return std::array{colour.red, colour.green, colour.blue}[static_cast<std::size_t>(channel)];
    });
    files_.colour.push_back(path() / fmt::format("light_{}.png", channel));
    write_image(files_.colour.back(), picture);
  }
  write_scan_files(path() / "scan.yaml", files_);

  expect_same(load_scan(path()).colour, lit);
  EXPECT_EQ(read_scan_files(path() / "scan.yaml").colour, files_.colour);
}

TEST_F(ScanColour, MayComeFromOnePictureInColour) {
  files_.colour = {path() / "colour.png"};
  write_image(files_.colour.front(), painted(1));
  write_scan_files(path() / "scan.yaml", files_);
  expect_same(load_scan(path()).colour, painted(1));

  write_image(files_.colour.front(), Image<std::uint8_t>(scanner.camera.size, 90));
  expect_error([&] { (void)load_scan(path()); }, {"colour.png", "grey picture"});
  write_image(files_.colour.front(), Image<Colour>({20, 10}, Colour{1, 2, 3}));
  expect_error([&] { (void)load_scan(path()); }, {"20x10", "48x36"});
}

TEST_F(ScanColour, MayComeFromAnotherCameraOfTheProjector) {
  // A picture whose red and green are the place of the pixel.
  const Scanner second = second_scanner(scanner);
  Image<Colour> picture(second.camera.size);
  for_each_pixel_in_order(picture.size(), [&](int column, int row) {
    picture(column, row) = {static_cast<std::uint8_t>(column + 1),
                            static_cast<std::uint8_t>(row + 1), 0};
  });
  files_.colour = {path() / "other.png"};
  files_.colour_scanner = path() / "other.yaml";
  write_image(files_.colour.front(), picture);
  write_scanner(*files_.colour_scanner, second);
  write_scan_files(path() / "scan.yaml", files_);

  const Scan scan = load_scan(path());
  EXPECT_TRUE(scan.colour.empty());
  const Cloud cloud = reconstruct(scan).cloud;
  const Eigen::Matrix3d to_other = second.rotation.transpose();
  int seen = 0;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    const Colour colour = cloud.colour(column, row);
    if (colour == Colour{}) return;
    const Eigen::Vector3d in_projector =
        in_projector_frame(scanner, position_at(cloud, column, row));
    const Eigen::Vector2d pixel =
        project(second.camera, to_other * (in_projector - second.translation));
    ++seen;
    EXPECT_NEAR(colour.red, pixel.x() + 1, 0.51);
    EXPECT_NEAR(colour.green, pixel.y() + 1, 0.51);
  });
  EXPECT_GT(seen, 100);

  write_image(files_.colour.front(), Image<Colour>({20, 10}, Colour{1, 2, 3}));
  expect_error([&] { (void)load_scan(path()); }, {"other.yaml", "20x10"});
  files_.colour.clear();
  write_scan_files(path() / "scan.yaml", files_);
  expect_error([&] { (void)load_scan(path()); }, {"colour_scanner", "missing"});
}

TEST_F(ScanColour, IsBalancedByTheGreyPatchElseByTheScanner) {
  // A camera that sees half as much blue, and the grey strip on the right.
  const auto frame_with_less_blue = [&](std::size_t n) {
    Image<Colour> picture = painted(n);
    for (Colour& colour : picture) colour.blue = static_cast<std::uint8_t>(colour.blue / 2);
    return picture;
  };
  for (std::size_t n = 0; n < frames_.size(); ++n) {
    write_image(files_.frames[n], frame_with_less_blue(n));
  }

  // A lit place of the grey strip.
  const Rectangle patch{32, 15, {3, 6}};
  ScanFiles asked = scan_files_in(path(), {.grey_patch = patch});
  const WhiteBalance balance = white_balance_of(asked);
  EXPECT_NEAR(balance[0], 1, 0.02);
  EXPECT_NEAR(balance[2], 2, 0.05);
  expect_same(load_scan(asked).colour, mean(), 4);

  // The same from the scanner file.
  Scanner known = scanner;
  known.photometry.white_balance = balance;
  write_scanner(path() / "scanner.yaml", known);
  expect_same(load_scan(path()).colour, mean(), 4);

  asked.grey_patch = Rectangle{40, 30, {20, 20}};
  expect_error([&] { (void)load_scan(asked); }, {"`grey_patch`", "48x36"});
}

TEST_F(ScanColour, GreyPatchNeedsColour) {
  expect_error(
      [&] {
        (void)load_scan(path(), {.grey_patch = Rectangle{1, 1, {2, 2}}});
      },
      {"`grey_patch`", "no colour"});
}

TEST_F(ScanColour, KeysAreRefusedIfTheyMakeNoSense) {
  files_.colour = {path() / "a.png", path() / "b.png"};
  write_scan_files(path() / "scan.yaml", files_);
  expect_error([&] { (void)load_scan(path()); }, {"colour", "three"});
  expect_error([&] { (void)amend(files_, {.mosaic = "RB"}); }, {"`mosaic RB`", "BayerRG8"});
}

// Red is saturated wherever the projector lights, so that neither red nor grey has a phase there.
TEST_F(ScanColour, DepthIsOfTheChannelThatIsNotSaturated) {
  for (std::size_t n = 0; n < frames_.size(); ++n) {
    Image<Colour> picture = painted(n);
    for (Colour& colour : picture) {
      colour.red = static_cast<std::uint8_t>(std::min(8 * colour.red, 255));
    }
    write_image(files_.frames[n], picture);
  }

  const Scan scan = load_scan(path());
  ASSERT_EQ(scan.warnings.size(), 1U);
  EXPECT_NE(scan.warnings.front().find("green channel"), std::string::npos)
      << scan.warnings.front();
  const ScanResult result = reconstruct(scan);
  EXPECT_EQ(result.counts[static_cast<std::size_t>(Validity::saturated)], 0U);
}

}  // namespace slipstream::scan_colour_test
