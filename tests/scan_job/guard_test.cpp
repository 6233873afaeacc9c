// Scans whose rig has moved since its calibration, and their guards.
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "codes/guard_sequence.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan_job.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream::guard_test {

const Scanner rig = example_scanner({160, 120});

FrameSet frames_of(const Sequence& sequence, const std::string& scene, std::uint64_t seed) {
  Photometry photometry = photometry_named("bench");
  photometry.seed = seed;
  return take_scan(rig, scene_named(scene, rig), pattern_set(sequence), photometry).frames;
}

/// A scan along an axis, with its guard.
Scan guarded_scan(const std::string& scene = "statue", Axis axis = Axis::x,
                  std::uint64_t seed = 1) {
  const Sequence sequence{.strategy = make_strategy("dual-frequency", {{"high", 16}}),
                          .axis = axis,
                          .projector = rig.projector.size};
  Scan scan{.frames = frames_of(sequence, scene, seed), .sequence = sequence, .scanner = rig};

  const Sequence guard = guard_sequence(sequence);
  scan.guard.push_back({.frames = frames_of(guard, scene, seed + 1), .sequence = guard});
  return scan;
}

/// The result, also of a scan that would be refused.
ScanResult result_of(const Scan& scan) {
  return reconstruct(scan, {.keep_refused = true});
}

/// The finding of the guard; a default one, of FindingKind::other, without.
Finding guard_finding(const ScanResult& result) {
  for (const Finding& finding : result.checked.findings) {
    if (finding.kind == FindingKind::axes_disagree) return finding;
  }
  return {};
}

/// Expects that the scan is refused or warned about, with one of its causes so called.
void expect_told(const Scan& scan, const std::string& cause) {
  const ScanResult result = result_of(scan);
  const Finding finding = guard_finding(result);
  ASSERT_EQ(finding.kind, FindingKind::axes_disagree) << cause;
  EXPECT_NE(causes_of(finding).find(cause), std::string::npos) << text_of(finding);
  ASSERT_TRUE(result.guard);
  EXPECT_GT(result.guard->common, 0.5);
}

Eigen::Matrix3d turn(double degrees, int axis) {
  const double angle = degrees * std::numbers::pi / 180;
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

TEST(Guard, IsSilentWhereTheRigStands) {
  for (const char* const scene : {"statue", "boxes", "board", "sphere"}) {
    for (const Axis axis : {Axis::x, Axis::y}) {
      const ScanResult result = result_of(guarded_scan(scene, axis, axis == Axis::x ? 1 : 7));
      EXPECT_EQ(guard_finding(result).kind, FindingKind::other)
          << scene << text_of(guard_finding(result));
      ASSERT_TRUE(result.guard) << scene;
      EXPECT_LT(result.guard->common, 0.3) << scene;
      EXPECT_FALSE(result.epipolar);
    }
  }
}

TEST(Guard, MakesNoDifferenceToTheCloud) {
  Scan scan = guarded_scan();
  const ScanResult guarded = reconstruct(scan);
  scan.guard.clear();
  const ScanResult alone = reconstruct(scan);
  EXPECT_EQ(guarded.counts, alone.counts);
  EXPECT_FALSE(alone.guard);
}

TEST(Guard, TellsATurnOfTheCamera) {
  Scan scan = guarded_scan();
  for (const double degrees : {0.2, 1.0, 3.0}) {
    for (const int axis : {0, 1, 2}) {
      scan.scanner = rig;
      scan.scanner->rotation = turn(degrees, axis) * rig.rotation;
      expect_told(scan, "the camera turned by");
    }
  }
}

TEST(Guard, TellsATurnOfTheProjector) {
  Scan scan = guarded_scan();
  scan.scanner->rotation = turn(1, 1) * rig.rotation;
  scan.scanner->translation = turn(1, 1) * rig.translation;
  expect_told(scan, "the projector turned by");
}

TEST(Guard, TellsAMoveOfFiveMillimetres) {
  Scan scan = guarded_scan("boxes");
  for (const int axis : {0, 1, 2}) {
    scan.scanner = rig;
    scan.scanner->translation[axis] += 5;
    expect_told(scan, "moved by");
  }
}

TEST(Guard, TellsAZoom) {
  Scan scan = guarded_scan();
  for (Lens Scanner::*const device : {&Scanner::camera, &Scanner::projector}) {
    scan.scanner = rig;
    ((*scan.scanner).*device).intrinsic.topLeftCorner<2, 2>() *= 1.02;
    expect_told(scan, "focal length changed by");
  }
}

TEST(Guard, TellsACroppedPicture) {
  Scan scan = guarded_scan();
  scan.scanner->camera.intrinsic(1, 2) += 4;
  expect_told(scan, "cropped or padded");
}

/// The frames, turned upside down.
FrameSet turned_frames(const FrameSet& frames) {
  std::vector<Image<std::uint8_t>> pictures(static_cast<std::size_t>(frames.count()),
                                            Image<std::uint8_t>(frames.size()));
  frames.visit([&](const auto& all) {
    for (std::size_t n = 0; n < pictures.size(); ++n) {
      for_each_pixel_in_order(frames.size(), [&](int column, int row) {
        const int right = frames.size().width - 1 - column, below = frames.size().height - 1 - row;
        pictures[n](column, row) = static_cast<std::uint8_t>(all[n](right, below));
      });
    }
  });
  return FrameSet(std::move(pictures), 8);
}

TEST(Guard, RefusesPicturesUpsideDown) {
  Scan scan = guarded_scan("board");
  scan.frames = turned_frames(scan.frames);
  scan.guard.front().frames = turned_frames(scan.guard.front().frames);
  expect_told(scan, "turned upside down");
  EXPECT_TRUE(any_wrong(result_of(scan).checked.findings));
}

TEST(Guard, RefusesTheScannerOfAnotherRig) {
  Scan scan = guarded_scan();
  scan.scanner->rotation = turn(4, 0) * turn(-6, 1) * rig.rotation;
  scan.scanner->translation = {-200, 20, 10};
  const Finding finding = guard_finding(result_of(scan));
  EXPECT_EQ(finding.severity, Severity::wrong);
  EXPECT_THROW((void)reconstruct(scan), RefusedScan);
}

TEST(Guard, TakesTheErrorOfTheCalibrationIntoAccount) {
  Scan scan = guarded_scan();
  scan.scanner->projector.intrinsic(1, 2) += 1;
  EXPECT_EQ(guard_finding(result_of(scan)).severity, Severity::doubtful);
  EXPECT_EQ(guard_finding(result_of(scan)).kind, FindingKind::axes_disagree);

  scan.scanner->calibration_rms = 0.8;
  EXPECT_EQ(guard_finding(result_of(scan)).kind, FindingKind::other);
}

/// Its own frames are checked first, so that it does not blame the rig.
TEST(Guard, BlamesNoRigForItsOwnFrames) {
  Scan scan = guarded_scan();
  Scan& guard = scan.guard.front();
  guard.frames = reordered(std::move(guard.frames), {0, 2, 1, 3, 4, 5});

  const ScanResult result = reconstruct(scan);
  ASSERT_FALSE(result.checked.findings.empty());
  EXPECT_EQ(result.checked.findings.front().subject, "guard");
  EXPECT_FALSE(any_wrong(result.checked.findings));
}

TEST(Guard, IsNotBlamedForPointsThatTheUserDoesNotWant) {
  ScanJobSettings trusted{.keep_refused = true}, small = trusted;
  trusted.reconstruct.clean.largest_sigma = 1e-3;
  small.reconstruct.clean.outline = {{0, 0}, {4, 4}};
  for (const ScanJobSettings& settings : {trusted, small}) {
    const ScanResult result = reconstruct(guarded_scan(), settings);
    EXPECT_LT(result.counts[0], 100U);
    EXPECT_EQ(guard_finding(result).kind, FindingKind::other) << text_of(guard_finding(result));
    ASSERT_TRUE(result.guard);
    EXPECT_GT(result.guard->points, 1000U);
  }
}

TEST(Guard, OfAnotherSceneIsNamedAsACause) {
  Scan scan = guarded_scan("boxes");
  scan.guard = guarded_scan("statue").guard;
  const Finding finding = guard_finding(result_of(scan));
  EXPECT_NE(causes_of(finding).find("between the scan and its guard"), std::string::npos)
      << text_of(finding);
}

TEST(Guard, IsComparedWithoutACloud) {
  Scan scan = guarded_scan();
  const GuardResult right = compare_with_guard(scan);
  ASSERT_TRUE(right.epipolar);
  EXPECT_TRUE(right.findings.empty());

  scan.scanner->rotation = turn(1, 0) * rig.rotation;
  const GuardResult moved = compare_with_guard(scan);
  ASSERT_EQ(moved.findings.size(), 1U);
  EXPECT_EQ(moved.findings.front().severity, Severity::wrong);

  // The check has these findings too.
  const ScanCheck checked = check(scan);
  ASSERT_EQ(checked.checked.findings.size(), 1U);
  EXPECT_TRUE(is_same(checked.checked.findings.front(), moved.findings.front()));
  EXPECT_EQ(checked.guard->common, moved.epipolar->common);

  scan.guard.clear();
  EXPECT_FALSE(compare_with_guard(scan).epipolar);
  EXPECT_TRUE(check(scan).checked.findings.empty());
}

}  // namespace slipstream::guard_test
