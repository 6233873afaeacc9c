#include "app/capture_desktop.h"

#include <utility>

#include "slipstream/devices/monitor_sink.h"

namespace slipstream::app {

struct CaptureDesktop::Windows {
  explicit Windows(const DesktopWishes& wishes) {
    if (wishes.monitor) projector.emplace(system, *wishes.monitor);
    if (wishes.guides) guide.emplace(system, "slipstream capture", wishes.size);
  }

  opengl::WindowSystem system;
  std::optional<monitor::MonitorSink> projector;
  std::optional<view::GuideWindow> guide;
};

CaptureDesktop::CaptureDesktop(const DesktopWishes& wishes)
    : windows_(wishes.monitor || wishes.guides ? std::make_unique<Windows>(wishes) : nullptr) {}

CaptureDesktop::~CaptureDesktop() = default;

PatternSink* CaptureDesktop::projector() {
  return windows_ && windows_->projector ? &*windows_->projector : nullptr;
}

bool CaptureDesktop::guides() const {
  return windows_ && windows_->guide;
}

void CaptureDesktop::show(view::Guide guide) {
  windows_->guide->show(std::move(guide));
}

bool CaptureDesktop::closed() {
  if (!windows_) return false;
  return (windows_->guide && windows_->guide->closed()) ||
         (windows_->projector && windows_->projector->closed());
}

Image<Colour> CaptureDesktop::picture() const {
  return windows_->guide->picture();
}

}  // namespace slipstream::app
