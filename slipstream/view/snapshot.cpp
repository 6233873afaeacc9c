#include "slipstream/view/snapshot.h"

#include "slipstream/opengl/off_screen.h"

namespace slipstream::view {

Image<Colour> render_snapshot(const PointImages& cloud, const Image<float>* modulation,
                              ViewSettings settings, const SceneLight& light, Size picture) {
  const opengl::OffScreenContext context;
  const opengl::RenderTarget target(picture);
  SceneRenderer scene;
  scene.set_extent(extent_of(cloud));
  scene.set_cloud(cloud, modulation, settings.colour);
  settings.camera = fitted(settings.camera, scene.extent().box, picture);
  target.bind();
  scene.draw(settings, light, picture);
  return opengl::read_pixels(picture);
}

}  // namespace slipstream::view
