#include "view/scene_renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

#include "base/names.h"
#include "base/object_range.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "view/lines.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"

namespace slipstream::view {
namespace {

// Comparisons are written so that NaN fails them.
constexpr const char* point_vertex_shader = R"(#version 330 core
layout(location = 0) in float x;
layout(location = 1) in float y;
layout(location = 2) in float z;
layout(location = 3) in float value;
layout(location = 4) in float brightness;
uniform mat4 clip;
uniform float pixel_size;
uniform float size_depth;
uniform vec2 range;
uniform int coloured;
uniform float floor_height;
uniform vec3 veil;
uniform float strength;
uniform sampler2D colours;
flat out vec3 colour;

void main() {
  vec3 point = vec3(x, y, z);
  bool drawn = abs(x) < 1e30 && abs(y) < 1e30 && abs(z) < 1e30 && y < floor_height;
  if (!drawn) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    colour = veil;
    return;
  }
  gl_Position = clip * vec4(point, 1.0);
  float growth = size_depth > 0.0 ? max(z / size_depth, 0.1) : 1.0;
  gl_PointSize = clamp(growth * pixel_size / max(gl_Position.w, 1e-6), 1.0, 64.0);
  float share = clamp((( coloured == 1 ? z : value) - range.x) / (range.y - range.x), 0.0, 1.0);
  vec3 lit = coloured == 1 ? texture(colours, vec2(share * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb
                           : vec3(pow(share, 1.0 / 2.2));
  if (coloured == 2) lit = mod(floor(value / vec3(65536.0, 256.0, 1.0)), 256.0) / 255.0;
  colour = mix(veil, lit * brightness, strength);
}
)";

constexpr const char* point_fragment_shader = R"(#version 330 core
flat in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(colour, 1.0); }
)";

/// Step between sampled pixels; odd, so that all columns of an even-width picture are sampled.
std::size_t stride_over(std::size_t count) {
  constexpr std::size_t enough = 8192;
  return (count / enough) | 1U;
}

/// Median distance of points `columns` apart in a row, per column; nullopt if there are too few.
std::optional<float> step_over(const PointImages& cloud, int columns) {
  constexpr std::size_t few = 16;
  const int width = cloud.z.width();
  const std::size_t count = cloud.z.pixel_count(), stride = stride_over(count);

  std::vector<float> steps;
  for (std::size_t i = 0; i < count; i += stride) {
    if (static_cast<int>(i % width) + columns >= width) continue;
    const auto between = [&](const Image<float>& image) {
      return image.begin()[i + columns] - image.begin()[i];
    };

    const float distance = std::hypot(between(cloud.x), between(cloud.y), between(cloud.z));
    if (std::isfinite(distance) && distance > 0) {
      steps.push_back(distance / static_cast<float>(columns));
    }
  }

  if (steps.empty() || (columns > 1 && steps.size() < few)) return std::nullopt;
  return quantile(steps, 0.5);
}

/// Organised: distance between neighbouring pixels' points along the surface. Noise of depth
/// lengthens the steps between neighbours, but hardly those over many columns: the shortest counts.
/// List of points: as if spread over the largest side of their box.
float spacing_of(const PointImages& cloud, const Box& box) {
  constexpr int most_columns = 32;

  std::optional<float> shortest;
  for (int columns = 1; cloud.z.height() > 1 && columns <= most_columns; columns *= 2) {
    const std::optional<float> step = step_over(cloud, columns);
    if (step) shortest = std::min(shortest.value_or(*step), *step);
  }

  if (shortest) return *shortest;

  const std::size_t count = cloud.z.pixel_count();
  const glm::vec3 sides = box.high - box.low;
  const float area = std::max({sides.x * sides.y, sides.y * sides.z, sides.x * sides.z});
  return std::sqrt(area / static_cast<float>(std::max<std::size_t>(count, 1)));
}

/// From second differences along rows, which a smooth surface hardly has.
float noise_of(const Image<float>& depth) {
  const int width = depth.width();
  const std::size_t count = depth.pixel_count(), stride = stride_over(count);

  std::vector<float> differences;
  for (std::size_t i = 0; i + 2 < count; i += stride) {
    const float* const at = depth.begin() + i;
    const float difference = std::abs(at[0] - 2 * at[1] + at[2]);
    if (static_cast<int>(i % width) + 2 < width && std::isfinite(difference)) {
      differences.push_back(difference);
    }
  }

  if (depth.height() < 2 || differences.empty()) return 0;
  const double median = quantile(differences, 0.5);
  return static_cast<float>(deviation_from_median(median) / std::sqrt(6.0));
}

constexpr glm::vec3 background(0.105F, 0.115F, 0.135F);

/// Indexed by PointColour.
constexpr std::array<std::string_view, 4> colour_names{"depth", "reflectivity", "modulation",
                                                       "camera"};

/// Intensities shown black and white, grey levels of 255: black at reflectivity 0, whose mean is
/// `ambient`, beta, by Liu 2010, Eq. (3.3); white at `range.high` divided by the brightness.
Range grey_range(PointColour colour, const Range& range, double ambient, float brightness) {
  const bool of_mean = colour != PointColour::modulation;

  const auto black = of_mean ? static_cast<float>(std::min(ambient, 0.9 * range.high)) : 0.0F;
  return {black, black + std::max(range.high - black, 1e-3F) / std::max(brightness, 1e-3F)};
}

}  // namespace

Range robust_range(const Image<float>& values) {
  std::vector<float> finite = finite_values(values, stride_over(values.pixel_count()));

  if (finite.empty()) return {};
  return {quantile(finite, 0.01), quantile(finite, 0.99)};
}

CloudExtent extent_of(const PointImages& cloud) {
  const Range x = robust_range(cloud.x), y = robust_range(cloud.y), z = robust_range(cloud.z);

  CloudExtent extent{.box = {{x.low, y.low, z.low}, {x.high, y.high, z.high}}, .depths = z};
  std::vector<float> depths = finite_values(cloud.z, stride_over(cloud.z.pixel_count()));
  if (!depths.empty()) std::tie(extent.depths.low, extent.depths.high) = range_of_object(depths);

  extent.spacing = std::max(spacing_of(cloud, extent.box), 1e-6F);
  extent.noise = noise_of(cloud.z);
  return extent;
}

float floor_height(const CloudExtent& extent) {
  return extent.box.high.y + 0.03F * extent.box.diagonal();
}

PointColour point_colour_named(std::string_view name) {
  const auto colour = value_named<PointColour>(name, colour_names);
  throw_if(!colour, "unknown point colour '{}'; expected depth, reflectivity, modulation or camera",
           name);
  return *colour;
}

std::vector<std::string_view> point_colour_names() {
  return {colour_names.begin(), colour_names.end()};
}

SceneRenderer::SceneRenderer()
    : program_({.vertex = point_vertex_shader, .fragment = point_fragment_shader}),
      vertex_array_(opengl::make_vertex_array()) {
  for (opengl::Resource& buffer : buffers_) buffer = opengl::make_buffer();

  // The depth colours, as a texture that the shader looks up.
  Image<Colour> colours({256, 1});
  std::ranges::copy(depth_colours(), colours.begin());
  colours_.upload(colours);
}

Range SceneRenderer::depths() const {
  const auto [low, high] = extent_.depths;
  const float margin = 0.04F * (high - low) + 1e-4F;
  return {low - margin, high + margin};
}

void SceneRenderer::set_cloud(const PointImages& cloud, const Image<float>* modulation,
                              PointColour colour) {
  // The quantity that grey points show.
  const bool known = modulation != nullptr && modulation->size() == cloud.z.size();
  const Image<float>& value =
      colour == PointColour::modulation && known ? *modulation : cloud.intensity;
  values_ = robust_range(value);

  // Or a colour, which a float holds as a whole number of 24 bits.
  in_colour_ = colour == PointColour::camera && cloud.colour != nullptr && !cloud.colour->empty();
  Image<float> packed;
  if (in_colour_) {
    packed = Image<float>(cloud.colour->size(), uninitialised);
    std::ranges::transform(*cloud.colour, packed.begin(), [](Colour of) {
      return static_cast<float>(of.red << 16 | of.green << 8 | of.blue);
    });
  }

  count_ = cloud.z.pixel_count();
  organised_ = cloud.z.height() > 1;
  shaded_ = cloud.shading != nullptr;

  const std::array<const Image<float>*, 5> images{&cloud.x, &cloud.y, &cloud.z,
                                                  in_colour_ ? &packed : &value, cloud.shading};
  for (std::size_t i = 0; i < (shaded_ ? 5U : 4U); ++i) {
    glBindBuffer(GL_ARRAY_BUFFER, *buffers_[i]);
    // New memory each time, so that drawing from the old does not block.
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(count_ * sizeof(float)),
                 images[i]->begin(), GL_STREAM_DRAW);
  }
}

void SceneRenderer::draw_points(const ViewSettings& settings, double ambient, Size picture,
                                bool mirrored) const {
  if (count_ == 0) return;

  // 1. Projection, colours and size. The reflection is the cloud mirrored in the floor.
  const float floor = floor_height(extent_);
  const glm::mat4 clip = mirrored ? mirrored_clip_matrix(settings.camera, picture, floor)
                                  : clip_matrix(settings.camera, picture);

  const bool coloured = shows_depths(settings.colour), shaded = settings.shaded && shaded_;
  const auto [low, high] =
      coloured ? depths() : grey_range(settings.colour, values_, ambient, settings.brightness);

  // Every third point at nearly twice the size: a dim, coarse reflection is cheap.
  const int every = mirrored ? 3 : 1;
  const float size = settings.point_size * extent_.spacing * (mirrored ? 1.7F : 1.0F);

  // 2. Numbers for the shader.
  program_.use();
  const auto at = [&](const char* name) { return program_.uniform(name); };
  glUniformMatrix4fv(at("clip"), 1, GL_FALSE, glm::value_ptr(clip));
  glUniform1f(at("pixel_size"), size * pixels_per_slope(settings.camera, picture));
  glUniform1f(at("size_depth"), organised_ ? extent_.box.centre().z : 0.0F);
  glUniform2f(at("range"), low, std::max(high, low + 1e-6F));
  const int of_camera = in_colour_ ? 2 : 0;
  glUniform1i(at("coloured"), coloured ? 1 : of_camera);
  glUniform1f(at("floor_height"), mirrored ? floor : 1e30F);
  glUniform3fv(at("veil"), 1, glm::value_ptr(mirrored ? background : glm::vec3(0)));
  glUniform1f(at("strength"), mirrored ? 0.3F : 1.0F);
  glUniform1i(at("colours"), 0);

  // 3. Texture and buffers. Without shading all points have brightness 1.
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, colours_.number());

  glEnable(GL_DEPTH_TEST);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glDisable(GL_BLEND);

  glBindVertexArray(*vertex_array_);
  for (GLuint i = 0; i < (shaded ? 5U : 4U); ++i) {
    glBindBuffer(GL_ARRAY_BUFFER, *buffers_[i]);
    glVertexAttribPointer(i, 1, GL_FLOAT, GL_FALSE, every * GLsizei{sizeof(float)}, nullptr);
    glEnableVertexAttribArray(i);
  }

  if (!shaded) {
    glDisableVertexAttribArray(4);
    glVertexAttrib1f(4, 1);
  }

  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count_) / every);
  glBindVertexArray(0);
}

void SceneRenderer::draw(const ViewSettings& settings, double ambient, const Pane& pane,
                         float pixel_ratio) const {
  glClearColor(background.r, background.g, background.b, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

  if (!settings.three_views) return draw_view(settings, ambient, pane, pixel_ratio);

  constexpr std::array viewpoints{Viewpoint::front, Viewpoint::side, Viewpoint::top};
  Pane part{.left = pane.left,
            .size = {std::max(pane.size.width / int{viewpoints.size()}, 1), pane.size.height}};
  for (const Viewpoint viewpoint : viewpoints) {
    ViewSettings view = settings;
    view.camera = fitted(looking_from(view.camera, viewpoint), extent_.box, part.size);
    draw_view(view, ambient, part, pixel_ratio);
    part.left += part.size.width;
  }
}

void SceneRenderer::draw_view(const ViewSettings& settings, double ambient, const Pane& pane,
                              float pixel_ratio) const {
  const Size picture = pane.size;
  glViewport(pane.left, 0, picture.width, picture.height);

  draw_points(settings, ambient, picture, false);
  if (settings.shaded) {
    const int reach = std::max(1, static_cast<int>(std::lround(pixel_ratio)));
    edges_.draw(pane, reach, extent_.noise / settings.camera.distance);
  }
  if (settings.reflection) draw_points(settings, ambient, picture, true);

  const glm::mat4 clip = clip_matrix(settings.camera, picture);
  if (settings.grid) {
    lines_.draw(floor_grid(extent_.box, floor_height(extent_)), clip, picture, pixel_ratio);
  }
  if (settings.axes) {
    lines_.draw(axes(extent_.box, settings.camera, directions_), clip, picture, 2 * pixel_ratio);
  }
}

}  // namespace slipstream::view
