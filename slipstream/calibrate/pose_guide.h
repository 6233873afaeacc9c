#pragma once

#include <array>
#include <filesystem>

#include "slipstream/base/colour.h"
#include "slipstream/calibrate/board_capture.h"
#include "slipstream/frames/scan_camera.h"

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
                       const CalibrationBoard& board, const BoardViews& taken);

/// What the poses that were taken lack for a good calibration.
struct PoseNeeds {
  static constexpr int cells = 3;  ///< of the camera's picture, across and down
  Image<std::uint8_t> coverage{};  ///< as coverage_map of the camera
  double covered = 0;              ///< share of the camera's picture
  std::array<std::array<bool, cells>, cells> seen_in{};  ///< [row][column]: half of it or more
  /// Whether the board's left, right, top or bottom edge was nearer to the camera than the one
  /// across, by 12 degrees of tilt or more.
  std::array<bool, 4> tilted{};
  bool enough = false;
  std::string advice{};  ///< how to hold the next one; empty where there are enough
};

/// `wanted`: how many poses are enough; 0: ten that are tilted each way and cover 60 % of the
/// camera's picture, or twenty. Tilts are those that a lens without distortion sees.
PoseNeeds pose_needs(const BoardViews& taken, const CalibrationBoard& board, Size camera,
                     int wanted);

/// The colour in which a state is told: green where the pose is good or taken, yellow where it only
/// has to be held still, red where something speaks against it.
Colour colour_of(PoseState state);

/// The picture with what guides a person drawn on it: dim and blue where no board was yet, the
/// outlines of the boards that were taken, the corners that are seen in the colour of the state,
/// and at each side an arrow for the edge that was nearer there, green, or that has yet to be,
/// orange. A small picture is enlarged, to `width` pixels at least, so that lines stay thin.
Image<Colour> drawn_guide(const Image<float>& picture, const PoseVerdict& verdict,
                          const PoseNeeds& needs, const BoardViews& taken, int width = 1600);

/// How a person stands with the poses of a board, each time something was seen.
struct PoseProgress {
  const FringeFreePictures& pictures;
  const PoseVerdict& verdict;
  const PoseNeeds& needs;
  const BoardViews& taken;
};

struct GuidedPosesSettings {
  /// Writes a scan of a pose that is taken into a new folder.
  std::function<void(const std::filesystem::path& folder, const Scan& scan)> save;
  int wanted = 0;  ///< see pose_needs
  BoardCaptureSettings capture{};
  std::function<void(const PoseProgress&)> told = {};  ///< called at every glimpse and pose
  std::function<bool()> ends = {};                     ///< asked again and again
};

/// Watches the board before the camera and takes a pose of it whenever it is good, until there are
/// enough or `ends` says so: scans along x and along y, into folders board01/x, board01/y,
/// board02/x and so on, as `calibrate geometry` reads them. A pose whose scans do not serve, by
/// board_capture, is refused and not kept; it is tried again once the board has moved. `camera`
/// gives the two scans of `sequence`, which is of no axis of its own. Returns the poses. Throws
/// Error where the folder holds something already, WorldError where it cannot be written.
BoardViews take_guided_poses(ScanCamera& camera, const std::filesystem::path& folder,
                             const CalibrationBoard& board, const Sequence& sequence,
                             const GuidedPosesSettings& settings);

}  // namespace slipstream
