#pragma once

#include <memory>
#include <optional>

#include "slipstream/frames/pattern_sink.h"
#include "slipstream/view/guide_window.h"

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
  /// Whether there is a window that guides.
  [[nodiscard]] bool guides() const;
  /// In that window.
  void show(view::Guide guide);
  /// Whether a window was closed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed();
  /// What that window showed last.
  [[nodiscard]] Image<Colour> picture() const;

 private:
  struct Windows;
  std::unique_ptr<Windows> windows_;
};

}  // namespace slipstream::app
