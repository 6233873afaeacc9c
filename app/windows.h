#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/flag_group.h"
#include "app/output.h"
#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/view/guide_window.h"
#include "slipstream/view/scene_renderer.h"

namespace slipstream::view {
struct ViewSource;
}

namespace slipstream::app {

/// The flags of all that draws clouds.
struct ViewFlags {
  std::string snapshot;    ///< file of a picture without panel; empty where none is wanted
  std::string screenshot;  ///< file of one with it
  Size size{1280, 800};
  view::ViewSettings settings{};
  std::string save_to = ".";
};

// The next three are there with SLIPSTREAM_VIEW.

/// Adds --snapshot, --screenshot, --size, --colour and --save-to.
void add_view_flags(CLI::App& subcommand, ViewFlags& flags);

/// Throws Error for a picture file of unknown ending.
void require_good(const ViewFlags& flags);

/// Draws --snapshot, and --screenshot where wanted, without a window, as far as they are given.
/// Throws WorldError where there is no cloud.
void write_pictures(const view::ViewSource& source, const ViewFlags& flags, bool screenshot_too,
                    Output& output);

/// What `capture` opens on the desktop.
struct DesktopWishes {
  std::optional<int> monitor{};  ///< the projector
  bool guides = false;           ///< a window that guides a person with a board
  Size size{};                   ///< of that window
};

/// The projector, where it is a monitor, and the window that guides; each only where it is wished.
struct CaptureDesktop {
  PatternSink* projector = nullptr;
  std::function<void(view::Guide guide)> show{};  ///< in the window that guides; empty without
  /// Whether a window was closed. Answers the desktop meanwhile.
  std::function<bool()> closed = [] { return false; };
  std::function<Image<Colour>()> picture{};  ///< what that window showed last
};

/// Throws Error for a monitor that is not there or a build without windows, WorldError where there
/// is no desktop.
CaptureDesktop open_desktop(const DesktopWishes& wishes);

}  // namespace slipstream::app
