// Things that move between the frames of a scan.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "geometry/triangulator.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "reconstruct/phase_matcher.h"
#include "slipstream/engine.h"
#include "slipstream/phase_shifting.h"
#include "tests/shared_data.h"

namespace slipstream::motion_test {
namespace fs = std::filesystem;

/// A hand that moves, under four steps of 28.5 periods shown over and over, seen by two cameras.
class MotionHand : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(folder_)) GTEST_SKIP() << folder_ << " is not there";
  }

  [[nodiscard]] FrameSet frames(const char* camera, int first, int count) const {
    std::vector<fs::path> files = images_in_folder(folder_ / camera);
    files = {files.begin() + first, files.begin() + first + count};
    return read_frames(files).frames;
  }

  [[nodiscard]] Eigen::Matrix<double, 3, 4> matrix(const char* name) const {
    std::ifstream file(folder_ / name);
    Eigen::Matrix<double, 3, 4> read;
    for (int i = 0; i < 12; ++i) file >> read(i / 4, i % 4);
    return read;
  }

  [[nodiscard]] Scanner scanner(const char* camera) const {
    return scanner_of(matrix(camera), {640, 480}, matrix("mProjector.txt"), {1280, 800});
  }

  const fs::path folder_ = shared_data() / "bsc-hand";
  /// The files do not say where the phase begins; from here the depths by the projector are, on
  /// average, those by the two cameras.
  const Strategy cycle_ = PhaseMeasuring{4, 28.5, {.origin = -1.2}};
};

/// Amplitude of the error at twice the phase, over what is lit in both, rad.
double ripple(const Maps& maps, const Maps& truth) {
  using Terms = Eigen::Matrix<double, 5, 1>;
  Eigen::Matrix<double, 5, 5> A = Eigen::Matrix<double, 5, 5>::Zero();
  Terms b = Terms::Zero();
  for (std::size_t i = 0; i < maps.mean.pixel_count(); ++i) {
    if (!(truth.modulation.begin()[i] > 15)) continue;
    const double phi = truth.wrapped_phase.begin()[i];
    const double error = std::remainder(maps.wrapped_phase.begin()[i] - phi, 2 * std::numbers::pi);
    if (std::abs(error) > 0.5) continue;
    const Terms terms{{1, std::cos(phi), std::sin(phi), std::cos(2 * phi), std::sin(2 * phi)}};
    A += terms * terms.transpose();
    b += error * terms;
  }
  const Terms fitted = A.ldlt().solve(b);
  return fitted.tail<2>().norm();
}

TEST_F(MotionHand, HasNoRippleUnderMotionWindows) {
  const auto maps_of = [&](int extra, int middle) {  // of the window between frames middle, + 1
    const int first = middle - 1 - extra / 2;
    const Sequence sequence{.strategy = cycle_, .projector = {1280, 800}, .motion = extra};
    Maps maps;
    Engine(scanner("mCamera1Rectified.txt"), merged_sequence(sequence, first % 4),
           {.nearest = 450, .farthest = 454})
        .maps(frames("cam1", first, 4 + extra), maps);
    return maps;
  };
  double sum = 0;
  for (int window = 0; window < 8; ++window) {
    const int middle = 5 + 4 * window;
    const Maps truth = maps_of(8, middle);
    const double four = ripple(maps_of(0, middle), truth);
    const double two_more = ripple(maps_of(2, middle), truth);
    const double four_more = ripple(maps_of(4, middle), truth);
    RecordProperty(fmt::format("ripple_{}", middle),
                   fmt::format("{:.4f} {:.4f} {:.4f}", four, two_more, four_more));
    EXPECT_GT(four, 0.025) << middle;
    // It goes with the third power of the speed: 0.003 but for the two where the hand is fastest.
    EXPECT_LE(two_more, four > 0.126 ? 0.0045 : 0.003) << middle;
    EXPECT_LE(four_more, 0.001) << middle;
    sum += two_more;
  }
  EXPECT_LE(sum / 8, 0.003);
}

TEST_F(MotionHand, HasItsFringeOrdersFromTheSecondCamera) {
  const Scanner first = scanner("mCamera1Rectified.txt"), second = scanner("mCamera2Rectified.txt");
  for (const int extra : {0, 2, 4}) {
    constexpr int begin = 8;
    const Sequence sequence =
        merged_sequence({.strategy = cycle_, .projector = {1280, 800}, .motion = extra}, begin % 4);
    PhaseMatcher match(first, second, sequence, {.nearest = 400, .farthest = 540}, {.window = 0});
    const Cloud cloud =
        match(frames("cam1", begin, 4 + extra), frames("cam2", begin, 4 + extra)).cloud;
    const ValidityCounts counts = count_by_validity(cloud);
    const auto count = [&](Validity reason) {
      return static_cast<double>(counts[static_cast<std::size_t>(reason)]);
    };
    const double lit = 640 * 480 - count(Validity::too_dark);
    RecordProperty(fmt::format("lit_{}", extra), static_cast<int>(lit));
    RecordProperty(fmt::format("points_{}", extra), static_cast<int>(count(Validity::valid)));
    RecordProperty(fmt::format("doubtful_{}", extra),
                   static_cast<int>(count(Validity::doubtful_order)));
    EXPECT_LT(count(Validity::doubtful_order), 0.055 * lit) << extra;
    EXPECT_GT(count(Validity::valid), 0.9 * lit) << extra;
  }
}

TEST_F(MotionHand, IsFoundWithoutDepthsOrOrigin) {
  const Scanner first = scanner("mCamera1Rectified.txt"), second = scanner("mCamera2Rectified.txt");
  const Sequence sequence{.strategy = PhaseMeasuring{4, 28.5}, .projector = {1280, 800}};
  PhaseMatcher match(first, second, sequence);
  const PhaseMatcher::Result result = match(frames("cam1", 8, 4), frames("cam2", 8, 4));
  ASSERT_TRUE(result.agreement);
  const double lit = 640 * 480 - static_cast<double>(count_by_validity(
                                     result.cloud)[static_cast<std::size_t>(Validity::too_dark)]);
  RecordProperty("points", static_cast<int>(point_count(result.cloud)));
  RecordProperty("origin", fmt::format("{:.4f}", -result.agreement->phase_shift));
  EXPECT_GT(static_cast<double>(point_count(result.cloud)), 0.9 * lit);
  EXPECT_NEAR(result.agreement->phase_shift, 1.2, 0.1);  // see cycle_
}

}  // namespace slipstream::motion_test
