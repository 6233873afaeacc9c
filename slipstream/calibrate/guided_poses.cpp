#include "slipstream/calibrate/guided_poses.h"

#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::array axes{Axis::x, Axis::y};

/// The poses of one board before one camera, as they are taken.
class GuidedPoses {
 public:
  GuidedPoses(ScanCamera& camera, fs::path folder, const CalibrationBoard& board,
              const Sequence& sequence, const GuidedPosesSettings& settings)
      : camera_(camera),
        folder_(std::move(folder)),
        board_(board),
        sequence_(sequence),
        settings_(settings) {}

  std::vector<BoardView> take_all() {
    while (!enough_ && !(settings_.ends && settings_.ends())) {
      const auto glimpse = camera_.look(std::chrono::milliseconds(200));
      if (glimpse) judge(*glimpse);
    }
    return std::move(taken_);
  }

 private:
  void judge(const Glimpse& glimpse) {
    const FringeFreePictures pictures =
        fringe_free_pictures(glimpse.frames.front(), glimpse.frames.back());
    PoseVerdict verdict = judge_pose(pictures, glimpse.still, board_, taken_);
    if (!glimpse.still) refused_.reset();
    if (verdict.state == PoseState::good && refused_) verdict = *refused_;
    tell(pictures, verdict);
    if (verdict.state != PoseState::good) return;
    std::optional<std::vector<FrameSet>> frames = camera_.take();
    if (frames) {
      verdict = keep(std::move(*frames), verdict);
    } else {
      verdict = {PoseState::moving, "it moved while it was taken: hold still", verdict.board};
    }
    if (verdict.state == PoseState::refused) refused_ = verdict;
    tell(pictures, verdict);
  }

  /// Writes the scans of a pose where they serve.
  PoseVerdict keep(std::vector<FrameSet> frames, const PoseVerdict& seen) {
    const std::string name = fmt::format("board{:02}", taken_.size() + 1);
    std::vector<Scan> scans;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      scans.push_back({.frames = std::move(frames.at(i)), .sequence = along(sequence_, axes[i])});
      scans.back().sequence.marker = false;  // none of the frames is one
    }
    BoardCapture found = board_capture(name, board_, scans[0], scans[1], settings_.capture);
    if (!found.view) return {PoseState::refused, "refused: " + found.told, seen.board};
    for (const Scan& scan : scans) {
      save_scan(folder_ / name / name_of(scan.sequence.axis), scan.frames, scan.sequence,
                std::nullopt);
    }
    taken_.push_back(std::move(*found.view));
    return {PoseState::taken, fmt::format("{} is taken: {}", name, found.told), seen.board};
  }

  void tell(const FringeFreePictures& pictures, const PoseVerdict& verdict) {
    const PoseNeeds needs = pose_needs(taken_, board_, pictures.mean.size(), settings_.wanted);
    enough_ = needs.enough;
    if (settings_.told) settings_.told({pictures, verdict, needs, taken_});
  }

  ScanCamera& camera_;
  fs::path folder_;
  const CalibrationBoard& board_;
  const Sequence& sequence_;
  const GuidedPosesSettings& settings_;
  std::vector<BoardView> taken_;
  std::optional<PoseVerdict> refused_;  ///< the pose that stands there still
  bool enough_ = false;
};

}  // namespace

std::vector<BoardView> take_guided_poses(ScanCamera& camera, const fs::path& folder,
                                         const CalibrationBoard& board, const Sequence& sequence,
                                         const GuidedPosesSettings& settings) {
  if (fs::exists(folder) && !fs::is_empty(folder)) {
    throw Error(fmt::format("{}: is not empty; name a new folder for the poses", folder.string()));
  }
  return GuidedPoses(camera, folder, board, sequence, settings).take_all();
}

}  // namespace slipstream
