// In place of capture_desktop.cpp, in builds without windows.
#include "app/capture_desktop.h"
#include "slipstream/base/error.h"

namespace slipstream::app {

struct CaptureDesktop::Windows {};

CaptureDesktop::CaptureDesktop(const DesktopWishes& wishes) {
  if (wishes.monitor) throw Error("--monitor: this build shows nothing on monitors");
  if (wishes.guides) throw Error("this build has no windows; add --headless");
}

CaptureDesktop::~CaptureDesktop() = default;

PatternSink* CaptureDesktop::projector() {
  return nullptr;
}

bool CaptureDesktop::guides() const {
  return false;
}

void CaptureDesktop::show(view::Guide) {}

bool CaptureDesktop::closed() {
  return false;
}

Image<Colour> CaptureDesktop::picture() const {
  return {};
}

}  // namespace slipstream::app
