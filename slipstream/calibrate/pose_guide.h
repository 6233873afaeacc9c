#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/calibrate/board_corners.h"
#include "slipstream/calibrate/board_view.h"

namespace slipstream {

/// Whether a pose of the board may be taken now, and if not why.
enum class PoseState { unseen, overexposed, dark, blurred, known, moving, good, refused, taken };

/// What is said of the board that stands before the camera.
struct PoseVerdict {
  PoseState state = PoseState::unseen;
  std::string words{};                  ///< one line for people: what is so, what to do
  std::optional<BoardCorners> board{};  ///< none where none is seen
};

/// Judges what is seen without fringes: unseen where there is no such board, overexposed from a
/// quarter of its pixels at full scale on, dark where its white is below 40 grey levels, blurred as
/// is_soft says, known where a pose that was `taken` has its corners within 3 % of the picture's
/// width, moving unless `still`.
PoseVerdict judge_pose(const FringeFreePictures& pictures, bool still,
                       const CalibrationBoard& board, const std::vector<BoardView>& taken);

/// Which edge of the board is nearer to the camera than the one across, by 12 degrees of tilt or
/// more.
enum class NearEdge { left, right, top, bottom };

/// What the poses that were taken lack for a good calibration.
struct PoseNeeds {
  static constexpr int cells = 3;  ///< of the camera's picture, across and down
  Image<std::uint8_t> coverage{};  ///< as coverage_map of the camera
  double covered = 0;              ///< share of the camera's picture
  std::array<std::array<bool, cells>, cells> seen_in{};  ///< [row][column]: half of it or more
  std::array<bool, 4> tilted{};                          ///< by NearEdge
  bool enough = false;
  std::string advice{};  ///< how to hold the next one; empty where there are enough
};

/// `wanted`: how many poses are enough; 0: ten that are tilted each way and cover 60 % of the
/// camera's picture, or twenty. Tilts are those that a lens without distortion sees.
PoseNeeds pose_needs(const std::vector<BoardView>& taken, const CalibrationBoard& board,
                     Size camera, int wanted);

}  // namespace slipstream
