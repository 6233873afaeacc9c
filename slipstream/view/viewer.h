#pragma once

#include <functional>
#include <optional>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/view/scene_renderer.h"
#include "slipstream/view/view_source.h"

namespace slipstream::view {

/// How the viewer runs.
struct ViewerSettings {
  ViewSettings view;
  Size size{1280, 800};         ///< of the window at first
  double most_per_second = 60;  ///< pictures; one that takes long is followed by a rest
  std::function<bool()> ends =
      {};                  ///< asked again and again: whether to close; the user alone if empty
  bool keep_last = false;  ///< the last picture is given back
};

/// Opens a window and shows the source until it is closed; in the main thread. Returns what it
/// showed last where that is wanted. Throws WorldError where there is no desktop or no OpenGL 3.3.
std::optional<Image<Colour>> run_viewer(const ViewSource& source, const ViewerSettings& settings);

/// What stands beside the cloud.
enum class Surround { nothing, panel };

/// What the viewer would show of the source's newest cloud in a window of that size, drawn without
/// one. Throws Error for a size out of range, WorldError where there is no OpenGL.
Image<Colour> render_screen(const ViewSource& source, const ViewSettings& settings, Size size,
                            Surround surround);

}  // namespace slipstream::view
