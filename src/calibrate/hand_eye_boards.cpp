#include "calibrate/hand_eye_boards.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "calibrate/board_corners.h"
#include "calibrate/board_view.h"
#include "calibrate/bundle_adjustment.h"
#include "calibrate/first_guess.h"

namespace slipstream {

PoseConvention board_table_convention() {
  return {.rotation = {.kind = RotationNotation::Kind::matrix}};
}

std::optional<BoardView> board_in_picture(const std::string& name, const CalibrationBoard& board,
                                          const Image<float>& picture) {
  auto found = find_board(board, {picture, picture});
  if (!found) return std::nullopt;

  const std::size_t corners = found->pixels.size();
  BoardView view{.name = name,
                 .places = std::move(found->places),
                 .camera = std::move(found->pixels),
                 .projector = PixelPlaces(corners, Eigen::Vector2d(nan, nan))};
  return view;
}

PoseTable board_table(BoardViews views, const CalibrationBoard& board, const Scanner& scanner) {
  const BoardPlaces printed = printed_places(board);
  const bool lit =
      std::ranges::any_of(views, [](const BoardView& view) { return lit_corners(view) > 0; });
  if (lit) views = checked_views(std::move(views), printed);

  // The camera's corners alone, then those of both devices.
  BundleState state = boards_before(scanner, views, printed);
  if (lit) state = bundle_adjusted(views, std::move(state), printed, all_held);

  PoseTable table;
  for (std::size_t v = 0; v < views.size(); ++v) {
    table.names.push_back(views[v].name);
    table.rows.push_back(row_of(state.poses[v], board_table_convention().rotation));
  }
  return table;
}

}  // namespace slipstream
