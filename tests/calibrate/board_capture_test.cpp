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

/// A board in the middle of the light, scanned along one axis.
Scan scan_of(const CalibrationBoard& board, Axis axis, const PatternLight& light = {}) {
  constexpr int pixels_per_spacing = 50;
  const Scanner scanner = example_scanner({480, 360});
  Body sheet = printed_sheet(draw_board(board, pixels_per_spacing),
                             board.spacing / pixels_per_spacing, scanner);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  sheet.pose = board_poses(scanner, 1, width, height).front();

  const Sequence sequence{.strategy = make_strategy("dual-frequency", {{"steps", 4}}),
                          .axis = axis,
                          .light = light,
                          .projector = scanner.projector.size};
  return {.frames = take_scan(scanner, {sheet}, pattern_set(sequence),
                              {.ambient = 5, .noise_variance = 1.55, .bits = 8})
                        .frames,
          .sequence = sequence};
}

// A camera's automatic exposure is on in all poses.
TEST(BoardCapture, CapturedPosesReportChangingLightOnce) {
  const CalibrationBoard board{};
  Scan x = scan_of(board, Axis::x), y = scan_of(board, Axis::y);
  for (Scan* scan : {&x, &y}) {
    pixels({1}, [](double level, int, int) { return 0.8 * level; })(*scan);
  }

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

TEST(BoardCapture, RefusesAPoseOfWrongFrames) {
  const CalibrationBoard board{};
  Scan x = scan_of(board, Axis::x);
  copied(5, 4)(x);
  const BoardCapture capture = board_capture("pose", board, x, scan_of(board, Axis::y));
  EXPECT_FALSE(capture.view);
  EXPECT_TRUE(capture.message.starts_with("likely a frame saved twice")) << capture.message;
}

TEST(BoardCapture, RefusesAPoseThatThePatternsHardlyLight) {
  const CalibrationBoard board{};
  const PatternLight faint{.alpha_p = 6, .beta_p = 200};
  const BoardCapture capture =
      board_capture("pose", board, scan_of(board, Axis::x, faint), scan_of(board, Axis::y, faint));
  EXPECT_FALSE(capture.view);
  EXPECT_TRUE(capture.message.starts_with("the projector lights 0 of ")) << capture.message;
}

}  // namespace slipstream::board_capture_test
