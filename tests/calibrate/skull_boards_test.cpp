// A published data set of six board poses, and its authors' calibration from five of them.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calibrate/board_view.h"
#include "calibrate/report.h"
#include "geometry/point_fit.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "reconstruct/pipeline.h"
#include "slipstream/board_capture.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "tests/shared_data.h"

namespace slipstream::skull_boards_test {
namespace fs = std::filesystem;

BoardCapture capture(const fs::path& folder, const CalibrationBoard& board, Size projector) {
  const std::vector<fs::path> pictures = images_in_folder(folder);
  const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
  const auto scan = [&](std::ptrdiff_t first, Axis axis) -> Scan {
    const auto begin = pictures.begin() + first;
    return {.frames = read_frames({begin, begin + 6}).frames,
            .sequence = {.strategy = strategy, .axis = axis, .projector = projector}};
  };
  return board_capture(folder.filename().string(), board, scan(0, Axis::x), scan(6, Axis::y));
}

/// RMS distance, pixel by pixel, between clouds of the skull from two calibrations, after rigid
/// alignment, mm.
double shape_difference(const fs::path& folder, const Scanner& a, const Scanner& b) {
  const FrameSet frames = read_frames(images_in_folder(folder)).frames;
  const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
  const auto cloud_of = [&](const Scanner& scanner) {
    return ReferenceEngine({scanner, {.strategy = strategy}, {}}, {})(frames).cloud;
  };
  const BasicCloud<double> cloud_a = cloud_of(a), cloud_b = cloud_of(b);
  std::vector<Eigen::Vector3d> points_a, points_b;
  for (std::size_t i = 0; i < cloud_a.z.pixel_count(); ++i) {
    const Eigen::Vector3d p(cloud_a.x.begin()[i], cloud_a.y.begin()[i], cloud_a.z.begin()[i]);
    const Eigen::Vector3d q(cloud_b.x.begin()[i], cloud_b.y.begin()[i], cloud_b.z.begin()[i]);
    if (!p.allFinite() || !q.allFinite()) continue;
    points_a.push_back(p);
    points_b.push_back(q);
  }
  using Points = Eigen::Map<const Eigen::Matrix3Xd>;
  const auto count = static_cast<Eigen::Index>(points_a.size());
  const Points A(points_a.front().data(), 3, count), B(points_b.front().data(), 3, count);
  const Eigen::Isometry3d onto_a = motion_between_points(B, A);
  const Eigen::Matrix3Xd moved = (onto_a.linear() * B).colwise() + onto_a.translation();
  return std::sqrt((A - moved).squaredNorm() / static_cast<double>(count));
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
    ASSERT_TRUE(found.view) << name << ": " << found.message;
    EXPECT_EQ(lit_corners(*found.view), 117) << name;
    if (name != std::string("board2")) views.push_back(*found.view);
  }
  const GeometryCalibration found = calibrate_geometry(views, board, camera, projector);
  for (const Finding& finding : found.findings) {
    // Five poses are few, and they cover less than a third of each image.
    EXPECT_TRUE(finding.what.find("distortion is not known") != std::string::npos ||
                finding.what.find("focal length is uncertain") != std::string::npos)
        << text_of(finding);
  }
  ASSERT_TRUE(found.state.scanner.calibrated_depths);
  EXPECT_NEAR(found.state.scanner.calibrated_depths->nearest, 306, 3);
  EXPECT_NEAR(found.state.scanner.calibrated_depths->farthest, 450, 3);
  EXPECT_LE(found.rms.camera, 0.28);
  EXPECT_LE(found.rms.projector, 0.40);
  EXPECT_LE(found.rms.stereo, 0.42);
  const BoardQuality own = overall(left_out_qualities(found));
  const BoardQuality published = overall(compared_with(read_scanner(folder / "calibration.xml"),
                                                       "published", views, printed_places(board))
                                             .poses);
  EXPECT_LE(own.flatness, published.flatness);
  EXPECT_LE(own.scale_error, published.scale_error);

  const double difference = shape_difference(folder / "dual-frequency", found.state.scanner,
                                             read_scanner(folder / "calibration.xml"));
  RecordProperty("skull_difference_mm", std::to_string(difference));
  EXPECT_LT(difference, 0.4);  // object size about 150 mm; the published scale is off by 0.3 %
}

}  // namespace slipstream::skull_boards_test
