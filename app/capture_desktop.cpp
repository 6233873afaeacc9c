#include "app/capture_desktop.h"

#include <fmt/format.h>

#include "app/view_files.h"
#include "slipstream/calibrate/pose_drawing.h"
#include "slipstream/project/monitor_sink.h"
#include "slipstream/view/guide_window.h"

namespace slipstream::app {
namespace {

std::vector<std::string> lines_of(const PoseProgress& progress) {
  const PoseNeeds& needs = progress.needs;
  return {needs.enough ? "enough poses: calibrating" : "next: " + needs.advice,
          fmt::format("{} taken; boards covered {:.0f} % of the camera's picture",
                      progress.taken.size(), 100 * needs.covered),
          "blue: no board was here yet; arrows: the edge that was nearer once (green), or has yet "
          "to be (orange)"};
}

}  // namespace

struct CaptureDesktop::Windows {
  explicit Windows(const DesktopWishes& wishes) {
    if (wishes.monitor) projector.emplace(system, *wishes.monitor);
    if (wishes.guides) guide.emplace(system, "slipstream capture", wishes.size);
  }

  opengl::WindowSystem system;
  std::optional<project::MonitorSink> projector;
  std::optional<view::GuideWindow> guide;
};

CaptureDesktop::CaptureDesktop(const DesktopWishes& wishes)
    : windows_(wishes.monitor || wishes.guides ? std::make_unique<Windows>(wishes) : nullptr) {}

CaptureDesktop::~CaptureDesktop() = default;

PatternSink* CaptureDesktop::projector() {
  return windows_ && windows_->projector ? &*windows_->projector : nullptr;
}

void CaptureDesktop::show(const PoseProgress& progress, const std::string& line) {
  if (!windows_ || !windows_->guide) return;
  windows_->guide->show(
      {drawn_guide(progress.pictures.mean, progress.verdict, progress.needs, progress.taken), line,
       colour_of(progress.verdict.state), lines_of(progress)});
}

bool CaptureDesktop::closed() {
  if (!windows_) return false;
  return (windows_->guide && windows_->guide->closed()) ||
         (windows_->projector && windows_->projector->closed());
}

void CaptureDesktop::write_screenshot(const std::string& file, Output& output) {
  if (!windows_ || !windows_->guide) return;
  write_picture("screenshot", file, windows_->guide->picture(), output);
}

}  // namespace slipstream::app
