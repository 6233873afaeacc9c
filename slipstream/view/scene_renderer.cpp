#include "slipstream/view/scene_renderer.h"

#include <algorithm>
#include <array>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::view {
namespace {

constexpr glm::vec3 background(0.105F, 0.115F, 0.135F);

/// By PointColour.
constexpr std::array<std::string_view, 3> colour_names{"reflectivity", "modulation", "depth"};

/// The intensities that look black and white: reflectivity 0, and that of `range.high` over the
/// brightness. Liu 2010, Eq. (3.3): reflectivity 0 has a mean of `ambient`, beta, grey levels of
/// 255.
Range grey_range(PointColour colour, const Range& range, double ambient, float brightness) {
  const bool of_mean = colour == PointColour::reflectivity;
  const auto black = of_mean ? static_cast<float>(std::min(ambient, 0.9 * range.high)) : 0.0F;
  return {black, black + std::max(range.high - black, 1e-3F) / std::max(brightness, 1e-3F)};
}

}  // namespace

PointColour point_colour_named(std::string_view name) {
  const auto found = std::find(colour_names.begin(), colour_names.end(), name);
  if (found != colour_names.end()) return static_cast<PointColour>(found - colour_names.begin());
  throw Error(fmt::format("'{}' is no colour of points; reflectivity, modulation or depth", name));
}

std::vector<std::string_view> point_colour_names() {
  return {colour_names.begin(), colour_names.end()};
}

Range SceneRenderer::depths() const {
  const float low = extent_.box.low.z, high = extent_.box.high.z;
  const float margin = 0.04F * (high - low) + 1e-4F;
  return {low - margin, high + margin};
}

void SceneRenderer::set_cloud(const PointImages& cloud, const Image<float>* modulation,
                              PointColour colour) {
  const bool known = modulation != nullptr && modulation->size() == cloud.z.size();
  const Image<float>& value =
      colour == PointColour::modulation && known ? *modulation : cloud.intensity;
  points_.upload(cloud, value);
  values_ = robust_range(value);
}

void SceneRenderer::draw(const ViewSettings& settings, double ambient, const Pane& pane,
                         float pixel_ratio) const {
  const Size picture = pane.size;
  glViewport(pane.left, pane.bottom, picture.width, picture.height);
  glClearColor(background.r, background.g, background.b, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

  const float floor = floor_height(extent_);
  const bool coloured = shows_depths(settings.colour);
  PointPass pass{.clip = clip_matrix(settings.camera, picture),
                 .point_size = settings.point_size * extent_.spacing,
                 .size_depth = extent_.box.centre().z,
                 .pixels_per_slope = pixels_per_slope(settings.camera, picture),
                 .coloured = coloured,
                 .range = coloured
                              ? depths()
                              : grey_range(settings.colour, values_, ambient, settings.brightness),
                 .shaded = settings.shaded};
  points_.draw(pass);
  if (settings.reflection) {
    // One point of three at nearly twice the size: a mirror may be dim and coarse, and is cheap so.
    pass.clip = mirrored_clip_matrix(settings.camera, picture, floor);
    pass.floor = floor;
    pass.veil = background;
    pass.strength = 0.3F;
    pass.every = 3;
    pass.point_size *= 1.7F;
    points_.draw(pass);
  }
  const glm::mat4 clip = clip_matrix(settings.camera, picture);
  if (settings.grid) lines_.draw(floor_grid(extent_.box, floor), clip, picture, pixel_ratio);
  if (settings.axes) {
    lines_.draw(axes(extent_.box, settings.camera), clip, picture, 2 * pixel_ratio);
  }
}

}  // namespace slipstream::view
