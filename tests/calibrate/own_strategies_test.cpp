// Boards can be captured with any strategy that gives a coordinate.
#include "tests/own_strategies.h"

#include <cmath>
#include <variant>

#include <gtest/gtest.h>

#include "calibrate/board_view.h"
#include "slipstream/board_capture.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::own_strategies_test {

TEST(OwnStrategies, BoardCaptureTakesStrategiesOfOnesOwn) {
  const Scanner scanner = example_scanner({640, 480});
  const CalibrationBoard board{.columns = 13, .rows = 9, .spacing = 15};
  constexpr int pixels_per_spacing = 100;
  Body sheet = printed_sheet(draw_board(board, pixels_per_spacing),
                             board.spacing / pixels_per_spacing, scanner);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  sheet.pose = board_poses(scanner, 3, width, height).front();
  for (const Strategy& strategy : own_strategies()) {
    SCOPED_TRACE(strategy.name());
    const auto scan_along = [&](Axis axis) -> Scan {
      const Sequence sequence{
          .strategy = strategy, .axis = axis, .projector = scanner.projector.size};
      return {.frames = take_scan(scanner, {sheet}, pattern_set(sequence),
                                  {.ambient = 5, .noise_variance = 1.55, .bits = 8})
                            .frames,
              .sequence = sequence};
    };
    const BoardCapture capture =
        board_capture("pose", board, scan_along(Axis::x), scan_along(Axis::y));
    ASSERT_TRUE(capture.view) << capture.message;
    EXPECT_EQ(lit_corners(*capture.view), 117) << capture.message;
    // One period alone is less accurate than fine fringes.
    const double tolerance = highest_frequency(strategy) > 1 ? 0.3 : 3;  // projector pixels
    double sum = 0;
    for (std::size_t i = 0; i < capture.view->places.size(); ++i) {
      const Eigen::Vector3d on_board =
          printed_places(board)[static_cast<std::size_t>(capture.view->places[i])];
      const Eigen::Vector3d middle =
          (printed_places(board).front() + printed_places(board).back()) / 2;
      const Eigen::Vector3d point = sheet.pose * (on_board - middle);
      sum += (capture.view->projector[i] -
              project(scanner.projector, in_projector_frame(scanner, point)))
                 .squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / 117), tolerance);
  }
}

}  // namespace slipstream::own_strategies_test
