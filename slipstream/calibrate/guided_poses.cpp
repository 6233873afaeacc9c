#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/calibrate/pose_guide.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::array axes{Axis::x, Axis::y};

/// The poses of one board before one camera, as they are taken.
struct GuidedPoses {
  ScanCamera& camera;
  const fs::path& folder;
  const CalibrationBoard& board;
  const Sequence& sequence;
  const GuidedPosesSettings& settings;
  std::vector<BoardView> taken{};
  std::optional<PoseVerdict> refused{};  ///< the pose that stands there still
  bool enough = false;

  std::vector<BoardView> take_all() {
    while (!enough && !(settings.ends && settings.ends())) {
      const auto glimpse = camera.look(std::chrono::milliseconds(200));
      if (glimpse) judge(*glimpse);
    }
    return std::move(taken);
  }

  void judge(const Glimpse& glimpse) {
    const FringeFreePictures pictures =
        fringe_free_pictures(glimpse.frames.front(), glimpse.frames.back());
    PoseVerdict verdict = judge_pose(pictures, glimpse.still, board, taken);
    if (!glimpse.still) refused.reset();
    if (verdict.state == PoseState::good && refused) verdict = *refused;
    tell(pictures, verdict);
    if (verdict.state != PoseState::good) return;
    std::optional<std::vector<FrameSet>> frames = camera.take();
    if (frames) {
      verdict = keep(std::move(*frames), verdict);
    } else {
      verdict = {PoseState::moving, "it moved while it was taken: hold still", verdict.board};
    }
    if (verdict.state == PoseState::refused) refused = verdict;
    tell(pictures, verdict);
  }

  /// Writes the scans of a pose where they serve.
  PoseVerdict keep(std::vector<FrameSet> frames, const PoseVerdict& seen) {
    const std::string name = fmt::format("board{:02}", taken.size() + 1);
    std::vector<Scan> scans;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      scans.push_back({.frames = std::move(frames.at(i)), .sequence = along(sequence, axes[i])});
      scans.back().sequence.marker = false;  // none of the frames is one
    }
    BoardCapture found = board_capture(name, board, scans[0], scans[1], settings.capture);
    if (!found.view) return {PoseState::refused, "refused: " + found.told, seen.board};
    for (const Scan& scan : scans) {
      save_scan(folder / name / name_of(scan.sequence.axis), scan.frames, scan.sequence,
                std::nullopt);
    }
    taken.push_back(std::move(*found.view));
    return {PoseState::taken, fmt::format("{} is taken: {}", name, found.told), seen.board};
  }

  void tell(const FringeFreePictures& pictures, const PoseVerdict& verdict) {
    const PoseNeeds needs = pose_needs(taken, board, pictures.mean.size(), settings.wanted);
    enough = needs.enough;
    if (settings.told) settings.told({pictures, verdict, needs, taken});
  }
};

}  // namespace

std::vector<BoardView> take_guided_poses(ScanCamera& camera, const fs::path& folder,
                                         const CalibrationBoard& board, const Sequence& sequence,
                                         const GuidedPosesSettings& settings) {
  if (fs::exists(folder) && !fs::is_empty(folder)) {
    throw Error(fmt::format("{}: is not empty; name a new folder for the poses", folder.string()));
  }
  return GuidedPoses{camera, folder, board, sequence, settings}.take_all();
}

}  // namespace slipstream
