#include "slipstream/board_capture.h"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "calibrate/board_view.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/check/mistakes.h"

namespace slipstream::board_capture_test {

/// A board in the middle of the light, scanned along one axis with one frame darker.
Scan scan_with_changing_light(const CalibrationBoard& board, Axis axis) {
  constexpr int pixels_per_spacing = 50;
  const Scanner scanner = example_scanner({480, 360});
  Body sheet = printed_sheet(draw_board(board, pixels_per_spacing),
                             board.spacing / pixels_per_spacing, scanner);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  sheet.pose = board_poses(scanner, 1, width, height).front();

  const Sequence sequence{.strategy = make_strategy("dual-frequency", {{"steps", 4}}),
                          .axis = axis,
                          .projector = scanner.projector.size};
  Scan scan{.frames = take_scan(scanner, {sheet}, pattern_set(sequence),
                                {.ambient = 5, .noise_variance = 1.55, .bits = 8})
                          .frames,
            .sequence = sequence};
  pixels({1}, [](double level, int, int) { return 0.8 * level; })(scan);
  return scan;
}

// A camera's automatic exposure is on in all poses.
TEST(BoardCapture, CapturedPosesReportChangingLightOnce) {
  const CalibrationBoard board{};
  const Scan x = scan_with_changing_light(board, Axis::x);
  const Scan y = scan_with_changing_light(board, Axis::y);

  std::vector<BoardScans> poses;
  for (const char* const name : {"board01", "board02", "board03"}) {
    poses.push_back({name, [&](Axis axis) { return axis == Axis::x ? x : y; }});
  }

  const PoseCaptures captures =
      capture_poses("poses", poses, {}, board, {}, [](const std::string&) {});
  ASSERT_EQ(captures.views.size(), 3U) << captures.unused.front().why;

  const auto light =
      std::ranges::find(captures.findings, FindingKind::changing_light, &Finding::kind);
  ASSERT_NE(light, captures.findings.end());
  EXPECT_EQ(light->subject, "board01 along x and 5 more scans");
  EXPECT_EQ(std::ranges::count(captures.findings, FindingKind::changing_light, &Finding::kind), 1);
}

}  // namespace slipstream::board_capture_test
