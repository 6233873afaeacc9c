#pragma once

#include "slipstream/image/colour.h"
#include "slipstream/image/image.h"
#include "slipstream/view/scene_renderer.h"

namespace slipstream::view {

/// A picture of the cloud, drawn without a window and fitted into the picture at the angles of the
/// settings. `modulation`: see SceneRenderer. Throws WorldError where there is no OpenGL.
Image<Colour> render_snapshot(const PointImages& cloud, const Image<float>* modulation,
                              ViewSettings settings, const SceneLight& light, Size picture);

}  // namespace slipstream::view
