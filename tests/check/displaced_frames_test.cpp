#include "check/displaced_frames.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::displaced_frames_test {

/// The check of a scan whose camera was pushed by some pixels before frame `first`.
ScanFindings check_if_pushed(const std::string& scene, const Strategy& strategy, int first,
                             int pixels) {
  Scan scan = scene_scan(scene, strategy);
  Pictures pictures = pictures_of(scan);
  for (std::size_t n = static_cast<std::size_t>(first); n < pictures.size(); ++n) {
    for (int row = 0; row < pictures[n].height(); ++row) {
      std::shift_right(pictures[n].row(row), pictures[n].row(row) + pictures[n].width(), pixels);
    }
  }

  scan.frames = FrameSet(std::move(pictures));
  return check_scan(scan);
}

TEST(DisplacedFrames, AreToldIfTheCameraWasPushed) {
  for (const char* const scene : {"statue", "boxes"}) {
    for (const auto& [strategy, first] :
         {std::pair{make_strategy("dual-frequency", {{"steps", 4}}), 2},
          std::pair{make_strategy("multi-frequency", {{"steps", 4}}), 10},
          std::pair{make_strategy("gray", {{"bits", 9}, {"reference", "inverse"}}), 9}}) {
      const std::string text = told(check_if_pushed(scene, strategy, first, 1));
      EXPECT_NE(text.find("displaced"), std::string::npos)
          << label_of(strategy) << ", " << scene << ": " << text;
    }
  }
}

TEST(DisplacedFrames, AreRefusedIfTheyAreFarOff) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}});
  EXPECT_TRUE(any_wrong(check_if_pushed("statue", strategy, 2, 8).findings));
}

}  // namespace slipstream::displaced_frames_test
