#include "app/guided_poses.h"

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "app/calibrate_boards.h"
#include "calibrate/pose_guide.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

std::string headline_of(const PoseProgress& progress, int wanted) {
  const std::string of = wanted > 0 ? fmt::format(" of {}", wanted) : "";
  return fmt::format("{}{}: {}", progress.taken.size(), of, with_flags(progress.verdict.words));
}

view::Guide guide_of(const PoseProgress& progress, int wanted) {
  const PoseNeeds& needs = progress.needs;
  return {drawn_guide(progress.pictures.mean, progress.verdict, needs, progress.taken),
          headline_of(progress, wanted),
          colour_of(progress.verdict.state),
          {needs.enough ? "enough poses: calibrating" : "next: " + needs.advice,
           fmt::format("{} taken; boards cover {:.0f} % of the camera's picture",
                       progress.taken.size(), 100 * needs.covered),
           "blue: not covered yet; arrows: edges already tilted towards the camera (green), still "
           "to do (orange)"}};
}

}  // namespace

std::string take_poses(const CaptureFlags& flags, const CaptureRig& rig,
                       const std::function<void(view::Guide)>& show,
                       const std::function<bool()>& ends, Output& output) {
  const auto& [projector, opened, camera, guard] = rig;
  throw_if(opened.sequence.projector == Size{},
           "--projector is missing: give the projector's size in pixels, e.g. 1280x800");

  const CalibrationBoard board = board_from(flags.board);
  const auto tell_news = news_of(*opened.frames, output);

  // Called for each picture: the window shows all of them, the text only changes of the verdict.
  PoseState shown = PoseState::taken;
  const auto tell = [&](const PoseProgress& progress) {
    if (show) show(guide_of(progress, *flags.poses));
    if (shown == progress.verdict.state) return;
    shown = progress.verdict.state;

    // Once a pose is over, the advice is about the next one.
    const bool over = shown == PoseState::taken || shown == PoseState::known;
    const std::string& advice = progress.needs.advice;
    output.say("{}{}", headline_of(progress, *flags.poses),
               over && !advice.empty() ? "; next: " + advice : "");
  };

  const auto watch = [&] {
    tell_news();
    return ends();
  };

  const auto save = [&opened](const fs::path& folder, const Scan& scan) {
    save_scan(folder, scan.frames, scan.sequence,
              {.temperatures = temperatures_of(*opened.frames)});
  };

  // 1. Take poses until there are enough or the user stops.
  const std::size_t taken =
      take_guided_poses(*camera, flags.output, board, opened.sequence,
                        {.save = save, .wanted = *flags.poses, .on_progress = tell, .ends = watch})
          .size();

  opened.frames->stop();
  throw_if(taken == 0, "no pose was taken");

  // 2. Calibrate from the poses taken, also after a stop.
  const fs::path folder = flags.output;
  CalibrateGeometryFlags calibration;
  calibration.boards.folder = folder;
  calibration.boards.board = flags.board;
  calibration.result.scanner = folder / "scanner.yaml";
  calibration.result.report = folder / "report";
  calibrate_boards(calibration, output);

  output.add("poses_taken", taken, "folder", flags.output);
  return output.document["verdict"];
}

GuidedPoses::GuidedPoses(CaptureFlags flags, Output& output)
    : flags_(std::move(flags)),
      rig_(open_rig(flags_, output)),
      work_(std::async(std::launch::async, [this, &output] {
        const auto show = [this](view::Guide guide) {
          const std::lock_guard lock(mutex_);
          newest_ = std::move(guide);
        };
        return take_poses(
            flags_, rig_, show, [this] { return ending_.load(); }, output);
      })) {}

std::optional<view::Guide> GuidedPoses::newest() {
  const std::lock_guard lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

bool GuidedPoses::over() const {
  return work_.wait_for(std::chrono::seconds(0)) == std::future_status::ready ||
         rig_.projector.closed();
}

std::string GuidedPoses::finish() {
  ending_ = true;
  return work_.get();
}

}  // namespace slipstream::app
