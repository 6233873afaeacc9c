#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "calibrate/board_corners.h"
#include "frames/scan_camera.h"
#include "slipstream/board_capture.h"
#include "slipstream/image.h"

namespace slipstream {

/// State of the board in front of the camera.
enum class PoseState { unseen, overexposed, dark, blurred, known, moving, good, refused, taken };

/// Assessment of the board in front of the camera.
struct PoseVerdict {
  PoseState state = PoseState::unseen;
  std::string words{};                  ///< one line of text: the state and what to do
  std::optional<BoardCorners> board{};  ///< nullopt if no board is visible
};

/// Judges pictures without fringes: unseen without a board, overexposed if a quarter of its pixels
/// or more are at full scale, dark if its white is below 40 grey levels, blurred by is_soft, known
/// if a `taken` pose has its corners within 3 % of the picture's width, moving unless `still`.
PoseVerdict judge_pose(const FringeFreePictures& pictures, bool still,
                       const CalibrationBoard& board, const BoardViews& taken);

/// Coverage of the poses so far, and advice for the next one.
struct PoseNeeds {
  Image<std::uint8_t> coverage{};  ///< coverage_map of the camera
  double covered = 0;              ///< share of the camera's picture
  /// Whether the board's left, right, top or bottom edge was tilted towards the camera by 12
  /// degrees or more.
  std::array<bool, 4> tilted{};
  bool enough = false;
  std::string advice{};  ///< how to hold the next pose; empty once `enough`
};

/// `wanted`: number of poses; 0: ten that include every tilt and cover 60 % of the camera's
/// picture, or twenty. Estimates tilts with a lens without distortion.
PoseNeeds pose_needs(const BoardViews& taken, const CalibrationBoard& board, Size camera,
                     int wanted);

/// Display colour of a state: green if good or taken, yellow if the board must be held still, red
/// otherwise.
Colour colour_of(PoseState state);

/// The picture with guidance: uncovered areas dim and blue, outlines of the boards taken, visible
/// corners in the colour of the state, and at each side an arrow, green if a pose had that edge
/// tilted towards the camera, else orange. Enlarges small pictures to at least `width` pixels, so
/// that lines stay thin.
Image<Colour> drawn_guide(const Image<float>& picture, const PoseVerdict& verdict,
                          const PoseNeeds& needs, const BoardViews& taken, int width = 1600);

/// Progress of guided poses, reported for every picture.
struct PoseProgress {
  const FringeFreePictures& pictures;
  const PoseVerdict& verdict;
  const PoseNeeds& needs;
  const BoardViews& taken;
};

struct GuidedPosesSettings {
  /// Writes a scan of an accepted pose to a new folder.
  std::function<void(const std::filesystem::path& folder, const Scan& scan)> save;
  int wanted = 0;                                             ///< see pose_needs
  std::function<void(const PoseProgress&)> on_progress = {};  ///< called for every picture and pose
  std::function<bool()> ends = {};                            ///< polled; true stops
};

/// Watches the board and captures every good pose until there are enough or `ends` returns true:
/// scans along x and y, in folders board01/x, board01/y, board02/x and so on, as
/// `calibrate geometry` reads them. Discards a pose that board_capture rejects, and retries once
/// the board has moved. `camera` captures the two scans of `sequence`, whose axis is ignored.
/// Returns the poses. Throws Error if the folder is not empty, WorldError if it cannot be written.
BoardViews take_guided_poses(ScanCamera& camera, const std::filesystem::path& folder,
                             const CalibrationBoard& board, const Sequence& sequence,
                             const GuidedPosesSettings& settings);

}  // namespace slipstream
