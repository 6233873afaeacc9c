#pragma once

#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/size.h"

namespace slipstream::view {

/// A box in the camera's frame of the scanner, mm.
struct Box {
  glm::vec3 low{0}, high{0};

  [[nodiscard]] glm::vec3 centre() const { return 0.5F * (low + high); }
  [[nodiscard]] float diagonal() const;
};

/// From where the cloud is looked at: a place on a sphere round a target; upright as the scanner's
/// camera where all angles are 0. The display's frame is the scanner's after half a turn about X: Y
/// is up and the cloud shows its front.
struct OrbitCamera {
  glm::vec3 target{0};         ///< display's frame, mm
  float distance = 1000;       ///< mm, > 0
  float azimuth = 0;           ///< rad, to the right
  float elevation = 0;         ///< rad, up; within a right angle
  float field_of_view = 0.6F;  ///< rad, from the top of the picture to its bottom
};

/// The scanner's frame in the display's, and back: (x, -y, -z).
inline glm::vec3 in_display_frame(const glm::vec3& point) {
  return {point.x, -point.y, -point.z};
}

/// Turned by a drag across the picture, in shares of its height: right and down are positive.
OrbitCamera orbited(OrbitCamera camera, const glm::vec2& drag);

/// Moved so that what is at the target's distance follows a drag, in shares of the height.
OrbitCamera panned(OrbitCamera camera, const glm::vec2& drag);

/// Nearer by so many steps of a wheel, or farther where negative.
OrbitCamera zoomed(OrbitCamera camera, float steps);

/// From where a person looks: as the scanner's camera does, from the right, from above.
enum class Viewpoint { front, side, top };
OrbitCamera looking_from(OrbitCamera camera, Viewpoint viewpoint);

/// Looking at the box's middle from where all of it is seen, at the same angles.
OrbitCamera fitted(OrbitCamera camera, const Box& box, Size picture);

/// Display's frame to the eye's.
glm::mat4 view_matrix(const OrbitCamera& camera);

/// Scanner's frame to clip coordinates.
glm::mat4 clip_matrix(const OrbitCamera& camera, Size picture);

/// Scanner's frame to clip coordinates of its image in a mirror, the plane Y = `height`.
glm::mat4 mirrored_clip_matrix(const OrbitCamera& camera, Size picture, float height);

/// The place on the picture, pixels, of a point in clip coordinates; none where it is behind the
/// eye.
std::optional<glm::vec2> pixel_of(const glm::vec4& clip, Size picture);

/// How many pixels one millimetre takes at a distance of one millimetre from the eye.
float pixels_per_slope(const OrbitCamera& camera, Size picture);

}  // namespace slipstream::view
