#include "check/contradicting_frame.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::contradicting_frame_test {

/// Frame n as if the camera was pushed by so many pixels.
Scan shaken(const Scan& right, int n, int columns) {
  Pictures pictures = pictures_of(right);
  Image<std::uint8_t>& picture = pictures[static_cast<std::size_t>(n)];
  for (int row = 0; row < picture.height(); ++row) {
    std::shift_right(picture.row(row), picture.row(row) + picture.width(), columns);
  }

  Scan scan = right;
  scan.frames = FrameSet(std::move(pictures));
  return scan;
}

/// What is said of frame n, or of no frame.
std::vector<int> frames_named(const Scan& scan, std::string& told) {
  std::vector<int> frames;
  for (const Finding& finding : check_scan(scan).findings) {
    told += text_of(finding) + "\n";
    if (finding.kind == FindingKind::pattern_mismatch) frames = finding.frames;
  }
  return frames;
}

TEST(ContradictingFrame, IsNamedIfItWasShaken) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 5}}), make_strategy("pmp", {{"steps", 6}})}) {
    const Scan right = scene_scan("statue", strategy);
    for (const int frame : {1, 4}) {
      std::string told;
      EXPECT_EQ(frames_named(shaken(right, frame, 2), told), std::vector<int>{frame})
          << label_of(strategy) << ": " << told;
      EXPECT_EQ(told.find("gamma"), std::string::npos) << told;
    }
  }
}

TEST(ContradictingFrame, IsNoneIfTwoWereShaken) {
  const Scan right = scene_scan("statue", make_strategy("dual-frequency", {{"steps", 5}}));
  std::string told;
  EXPECT_EQ(frames_named(shaken(shaken(right, 1, 2), 3, 2), told), std::vector<int>()) << told;
}

// Neither one frame nor a displacement explains these: blur and edges of the object remain.
TEST(ContradictingFrame, AreToldTogetherIfTwoWereShaken) {
  for (const char* const scene : {"statue", "boxes"}) {
    Scan right = scene_scan(scene, make_strategy("pmp", {{"steps", 6}}));
    right.scanner->photometry.response = MeasuredResponse{PowerLaw{1}, 1, 0.01};
    EXPECT_TRUE(check_scan(right).findings.empty()) << scene;

    for (const int columns : {2, 4}) {
      const auto found = check_scan(shaken(shaken(right, 0, columns), 1, columns)).findings;
      ASSERT_FALSE(found.empty()) << scene << ", " << columns;
      EXPECT_EQ(found.front().kind, FindingKind::pattern_mismatch) << text_of(found.front());
    }
  }
}

// Blur takes harmonics of an unknown response away, most where periods are fine.
TEST(ContradictingFrame, IsNotSaidOfFinePeriodsThroughAResponse) {
  for (const double periods : {4, 12, 24}) {
    const VirtualWorld world =
        virtual_world({.scene = "boxes", .camera = {320, 240}, .world = "harsh,no-flicker"});
    const Strategy strategy = make_strategy("pmp", {{"steps", 6}, {"frequency", periods}});
    const std::string text = told(findings_of(world, strategy));
    EXPECT_EQ(text.find("contradict"), std::string::npos) << periods << ": " << text;
  }
}

// Four steps have one redundancy: it cannot tell every other frame apart.
TEST(ContradictingFrame, IsOneOfTwoInFourSteps) {
  const Scan right = scene_scan("statue", make_strategy("dual-frequency", {{"steps", 4}}));
  std::string told;
  EXPECT_EQ(frames_named(shaken(right, 1, 2), told), (std::vector{1, 3})) << told;
}

}  // namespace slipstream::contradicting_frame_test
