// Real captures by others, decoded as their own programs do.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "decode/decoder.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "slipstream/engine.h"
#include "slipstream/scanner.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "tests/shared_data.h"

namespace slipstream::captures_test {
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;

/// Grey levels of 64-bit TIFF, read as unquantised frames are.
Image<double> read_numbers(const fs::path& file) {
  Image<double> numbers;
  const LoadedFrames loaded = read_frames({file});
  const FrameViews& views = loaded.frames;
  views.visit([&](const auto& frames) {
    numbers = Image<double>(frames.front().size());
    for (int row = 0; row < numbers.height(); ++row) {
      for (int column = 0; column < numbers.width(); ++column) {
        numbers(column, row) = static_cast<double>(frames.front()(column, row));
      }
    }
  });
  return numbers;
}

double quantile_of(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Points whose depth jumps by more than `jump` mm from the median of 7 x 7 around them.
double share_off(const Cloud& cloud, double jump) {
  std::size_t off = 0, points = 0;
  for (int row = 3; row + 3 < cloud.z.height(); ++row) {
    for (int column = 3; column + 3 < cloud.z.width(); ++column) {
      const float z = cloud.z(column, row);
      if (!std::isfinite(z)) continue;
      std::vector<double> around;
      for (int r = -3; r <= 3; ++r) {
        for (int c = -3; c <= 3; ++c) {
          if (std::isfinite(cloud.z(column + c, row + r))) {
            around.push_back(cloud.z(column + c, row + r));
          }
        }
      }
      ++points;
      off += std::abs(z - quantile_of(around, 0.5)) > jump ? 1 : 0;
    }
  }
  return static_cast<double>(off) / static_cast<double>(points);
}

TEST(Captures, ReliefByGrayCodeAndPhase) {
  const fs::path folder = shared_data() / "slmaster-mono";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const LoadedFrames loaded = read_frames(images_in_folder(folder));
  const Strategy strategy = make_strategy("gray-phase", {{"steps", 12},
                                                         {"periods", 32},
                                                         {"bits", 5},
                                                         {"complementary", true},
                                                         {"origin", pi},
                                                         {"backwards", true}});
  const Scanner scanner =
      completed(read_scanner(folder / "caliInfo.yml"), "the scanner", {1280, 1024}, {1920, 1080});
  Cloud cloud;
  Engine(scanner, {.strategy = strategy, .projector = {1920, 1080}},
         {.minimum_modulation = 20, .clean = CleanSettings::none()})
      .cloud(loaded.frames, cloud);
  std::vector<double> depths;
  std::copy_if(cloud.z.begin(), cloud.z.end(), std::back_inserter(depths),
               [](float z) { return std::isfinite(z); });
  EXPECT_GT(depths.size(), 200000U);
  EXPECT_NEAR(quantile_of(depths, 0.05), 696, 1);
  EXPECT_NEAR(quantile_of(depths, 0.50), 727, 1);
  EXPECT_NEAR(quantile_of(depths, 0.95), 765, 1);
  // A period is some 30 mm deep there.
  EXPECT_LE(share_off(cloud, 12), 0.003);
  std::printf("%zu points, 5, 50, 95 %%: %.1f %.1f %.1f mm, %.3f %% off\n", depths.size(),
              quantile_of(depths, 0.05), quantile_of(depths, 0.5), quantile_of(depths, 0.95),
              100 * share_off(cloud, 12));
}

TEST(Captures, BoardByFourFrequenciesAsItsAuthorsUnwrapIt) {
  const fs::path folder = shared_data() / "cpsd-plane";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<fs::path> files;
  for (const char band : {'1', '2', '3', '4'}) {
    for (int step = 1; step <= 12; ++step) {
      files.push_back(folder / (std::string("f") + band + (step < 10 ? "_s0" : "_s") +
                                std::to_string(step) + ".png"));
    }
  }
  const LoadedFrames loaded = read_frames(files);
  const Image<double> theirs = read_numbers(folder / "phase_authors.tiff");
  const Image<double> mask = read_numbers(folder / "mask_authors.png");
  const Strategy strategy = MultiFrequency{
      .steps = {12}, .periods = {1, 4, 16, 64}, .unwrapping = "hierarchical", .shifts = {pi, true}};
  // So long that no pixel is brought from one end of the field to the other.
  const BasicMaps<double> maps =
      Decoder(strategy.layout(), 1 << 24, PhaseMethod::equation)(loaded.frames);
  std::size_t compared = 0;
  double worst = 0;
  for (std::size_t i = 0; i < theirs.pixel_count(); ++i) {
    if (mask.begin()[i] == 0 || !std::isfinite(theirs.begin()[i])) continue;
    ++compared;
    worst = std::max(worst, std::abs(2 * pi * 64 * maps.coordinate.begin()[i] - theirs.begin()[i]));
  }
  EXPECT_GT(compared, 600000U);
  EXPECT_LE(worst, 1e-9);
}

/// The code has stripes of 2 pixels, the phase periods of 240.
TEST(Captures, BoardByACodeAndAPhaseThatWereMadeApart) {
  const fs::path folder = shared_data() / "kamino-gamma";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  constexpr int columns = 1920;
  constexpr double periods = columns / 240.0;
  const std::vector<fs::path> all = images_in_folder(folder);
  const auto maps_by = [&](const Strategy& strategy, std::vector<fs::path> files) {
    files.insert(files.end(), all.begin() + 6, all.begin() + 26);
    return Decoder(strategy.layout(), columns, PhaseMethod::equation)(read_frames(files).frames);
  };
  const BasicMaps<double> by_code =
      maps_by(GrayCode{.reference = "inverse", .stripes = columns / 2.0}, {});

  // The three steps are bent by the projector's response, as CapturesGamma measures.
  for (const auto& [first, bent] : {std::pair{0, 0.193}, {3, 0.072}}) {
    const GrayPhase both{.steps = 3,
                         .periods = periods,
                         .stripes = columns / 2.0,
                         .reference = "inverse",
                         .shifts = {-2 * pi / 3, true}};
    const BasicMaps<double> maps = maps_by(both, {all.begin() + first, all.begin() + first + 3});

    std::size_t lit = 0, off = 0;
    double squares = 0;
    for (std::size_t i = 0; i < maps.coordinate.pixel_count(); ++i) {
      if (maps.modulation.begin()[i] < 30) continue;
      const double apart =
          2 * pi * periods * (maps.coordinate.begin()[i] - by_code.coordinate.begin()[i]);
      ++lit;
      off += std::abs(apart) > 1 ? 1 : 0;
      squares += std::abs(apart) > 1 ? 0 : apart * apart;
    }
    const double rms = std::sqrt(squares / static_cast<double>(lit));
    std::printf("from frame %d: %zu pixels, %.4f rad, %zu off\n", first, lit, rms, off);
    EXPECT_GT(lit, 1'700'000U);
    EXPECT_LE(off, lit / 10'000);
    EXPECT_NEAR(rms, bent, 0.05 * bent);
  }
}

class CapturesWaxBowl : public testing::TestWithParam<std::pair<std::string, double>> {};

TEST_P(CapturesWaxBowl, HasTheColumnsOfItsAuthors) {
  const auto& [name, least_share] = GetParam();
  const fs::path folder = shared_data() / "microps-waxbowl" / name;
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  constexpr double columns = 1024;
  std::vector<fs::path> files = images_in_folder(folder);
  std::erase_if(files, [](const fs::path& file) { return file.extension() != ".png"; });
  std::ifstream lengths(folder / "frequencyVec.txt");
  MicroPhaseShifting coding;
  coding.periods.clear();
  coding.shifts.backwards = true;
  for (double pixels = 0; lengths >> pixels;) coding.periods.push_back(columns / pixels);
  const LoadedFrames loaded = read_frames(files);
  ASSERT_EQ(loaded.frames.count(), Strategy(coding).layout().frames);
  const Image<double> theirs = read_numbers(folder / "IC.tiff");
  const BasicMaps<double> maps =
      Decoder(Strategy(coding).layout(), columns, PhaseMethod::equation)(loaded.frames);
  std::size_t compared = 0, near = 0;
  double mean = 0;
  for (std::size_t i = 0; i < theirs.pixel_count(); ++i) {
    if (!std::isfinite(theirs.begin()[i])) continue;
    const double apart = columns * maps.coordinate.begin()[i] + 1 - theirs.begin()[i];
    ++compared;
    near += std::abs(apart) <= 1.5 ? 1 : 0;
    if (std::abs(apart) <= 1.5) mean += apart;
  }
  const double share = static_cast<double>(near) / static_cast<double>(compared);
  std::printf("%s: %zu pixels, %.2f %% near, %.2f columns apart\n", name.c_str(), compared,
              100 * share, mean / static_cast<double>(near));
  EXPECT_GE(share, least_share);
}

INSTANTIATE_TEST_SUITE_P(Captures, CapturesWaxBowl,
                         testing::Values(std::pair(std::string("16-05"), 0.87),
                                         std::pair(std::string("32-08"), 0.995),
                                         std::pair(std::string("64-15"), 0.999)));

}  // namespace slipstream::captures_test
