#include "view/orbit_camera.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace slipstream::view {
namespace {

float aspect(Size picture) {
  return static_cast<float>(std::max(picture.width, 1)) /
         static_cast<float>(std::max(picture.height, 1));
}

constexpr float steepest = glm::half_pi<float>() - 0.01F;  // elevation; straight up has no azimuth

}  // namespace

OrbitCamera orbited(OrbitCamera camera, const glm::vec2& drag) {
  constexpr float turn = glm::pi<float>();  // angle for a drag over the whole height

  camera.azimuth = std::remainder(camera.azimuth - turn * drag.x, glm::two_pi<float>());
  camera.elevation = std::clamp(camera.elevation + turn * drag.y, -steepest, steepest);
  return camera;
}

OrbitCamera panned(OrbitCamera camera, const glm::vec2& drag) {
  // Move along the picture's axes, by the height of the visible field at the target.
  const glm::mat3 axes = glm::transpose(glm::mat3(view_matrix(camera)));
  const float height = 2 * camera.distance * std::tan(camera.field_of_view / 2);
  camera.target += height * (drag.y * axes[1] - drag.x * axes[0]);
  return camera;
}

OrbitCamera zoomed(OrbitCamera camera, float steps) {
  constexpr float nearest = 1e-3F, farthest = 1e7F;
  camera.distance = std::clamp(camera.distance * std::pow(0.88F, steps), nearest, farthest);
  return camera;
}

OrbitCamera looking_from(OrbitCamera camera, Viewpoint viewpoint) {
  constexpr float right_angle = glm::half_pi<float>();
  camera.azimuth = viewpoint == Viewpoint::side ? right_angle : 0;
  camera.elevation = viewpoint == Viewpoint::top ? steepest : 0;
  return camera;
}

OrbitCamera fitted(OrbitCamera camera, const Box& box, Size picture) {
  constexpr float margin = 1.06F;

  // The same angles, with the middle of the box as the target.
  camera.target = in_display_frame(box.centre());
  const glm::mat3 turn(view_matrix(camera));
  const float up = std::tan(camera.field_of_view / 2), across = up * aspect(picture);

  // The distance from which even the least favourable corner fits into the picture.
  camera.distance = 1e-3F;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 point((corner & 1) != 0 ? box.low.x : box.high.x,
                          (corner & 2) != 0 ? box.low.y : box.high.y,
                          (corner & 4) != 0 ? box.low.z : box.high.z);

    const glm::vec3 seen = turn * (in_display_frame(point) - camera.target);
    const float needed = seen.z + std::max(std::abs(seen.x) / across, std::abs(seen.y) / up);
    camera.distance = std::max(camera.distance, margin * needed);
  }

  return camera;
}

glm::mat4 view_matrix(const OrbitCamera& camera) {
  const glm::vec3 towards_eye(std::sin(camera.azimuth) * std::cos(camera.elevation),
                              std::sin(camera.elevation),
                              std::cos(camera.azimuth) * std::cos(camera.elevation));

  return glm::lookAt(camera.target + camera.distance * towards_eye, camera.target,
                     glm::vec3(0, 1, 0));
}

glm::mat4 clip_matrix(const OrbitCamera& camera, Size picture) {
  const glm::mat4 projection =
      glm::perspective(camera.field_of_view, aspect(picture), nearest_share * camera.distance,
                       farthest_share * camera.distance);

  return projection * view_matrix(camera) * glm::scale(glm::mat4(1), glm::vec3(1, -1, -1));
}

glm::mat4 mirrored_clip_matrix(const OrbitCamera& camera, Size picture, float height) {
  glm::mat4 mirror = glm::scale(glm::mat4(1), glm::vec3(1, -1, 1));
  mirror[3][1] = 2 * height;
  return clip_matrix(camera, picture) * mirror;
}

std::optional<glm::vec2> pixel_of(const glm::vec4& clip, Size picture) {
  if (!(clip.w > 0)) return std::nullopt;

  const float across = clip.x / clip.w, up = clip.y / clip.w;
  return glm::vec2(0.5F * (1 + across) * static_cast<float>(picture.width) - 0.5F,
                   0.5F * (1 - up) * static_cast<float>(picture.height) - 0.5F);
}

float pixels_per_slope(const OrbitCamera& camera, Size picture) {
  return static_cast<float>(picture.height) / (2 * std::tan(camera.field_of_view / 2));
}

}  // namespace slipstream::view
