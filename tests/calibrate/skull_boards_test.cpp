// Six real boards taken by others, and what others made of five of them.
#include <filesystem>

#include <gtest/gtest.h>

#include "slipstream/calibrate/board_capture.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/calibrate/report.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "tests/shared_data.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

BoardCapture capture(const fs::path& folder, const CalibrationBoard& board, Size projector) {
  const std::vector<fs::path> pictures = images_in_folder(folder);
  const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
  const auto scan = [&](std::ptrdiff_t first) -> AxisScan {
    const auto begin = pictures.begin() + first;
    return {strategy, read_frames({begin, begin + 6}).frames};
  };
  return board_capture(folder.filename().string(), board, scan(0), scan(6), projector);
}

TEST(SkullBoards, AreCalibratedAtLeastAsWellAsPublished) {
  const fs::path folder = shared_data() / "skull";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "too slow under the sanitizers";
#endif
  const CalibrationBoard board{.columns = 13, .rows = 9, .spacing = 10};
  const Size camera{1688, 1352}, projector{1824, 1140};
  std::vector<BoardView> views;
  for (const char* name : {"board1", "board2", "board3", "board4", "board5", "board6"}) {
    const BoardCapture found = capture(folder / "calibration" / name, board, projector);
    ASSERT_TRUE(found.view) << name << ": " << found.told;
    EXPECT_EQ(lit_corners(*found.view), 117) << name;
    if (name != std::string("board2")) views.push_back(*found.view);
  }
  const GeometryCalibration found = calibrate_geometry(views, board, camera, projector);
  EXPECT_LE(found.rms.camera, 0.28);
  EXPECT_LE(found.rms.projector, 0.40);
  EXPECT_LE(found.rms.stereo, 0.42);
  const BoardQuality own = overall(left_out_qualities(found));
  const BoardQuality published = overall(
      compared_with(read_scanner(folder / "calibration.xml"), "published", views, board).poses);
  EXPECT_LE(own.flatness, published.flatness);
  EXPECT_LE(own.scale_error, published.scale_error);
}

}  // namespace
}  // namespace slipstream
