#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/output.h"
#include "slipstream/calibrate/guided_poses.h"
#include "slipstream/capture/pattern_sink.h"

namespace slipstream::app {

/// What `capture` opens on the desktop.
struct DesktopWishes {
  std::optional<int> monitor{};  ///< the projector
  bool guides = false;           ///< a window that guides a person with a board
  Size size{};                   ///< of that window
};

/// The projector, where it is a monitor, and the window that guides; each only where it is wished.
/// Nothing of either in builds without windows.
class CaptureDesktop {
 public:
  /// Throws Error for a monitor that is not there or a build without windows, WorldError where
  /// there is no desktop.
  explicit CaptureDesktop(const DesktopWishes& wishes);
  ~CaptureDesktop();
  CaptureDesktop(const CaptureDesktop&) = delete;
  CaptureDesktop& operator=(const CaptureDesktop&) = delete;

  /// Null where none is wished.
  [[nodiscard]] PatternSink* projector();
  /// In the window, where there is one; `line` is what a terminal would show.
  void show(const PoseProgress& progress, const std::string& line);
  /// Whether a window was closed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed();
  /// Writes what the window showed last, where it is open.
  void write_screenshot(const std::string& file, Output& output);

 private:
  struct Windows;
  std::unique_ptr<Windows> windows_;
};

}  // namespace slipstream::app
