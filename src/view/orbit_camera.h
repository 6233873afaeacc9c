#pragma once

#include <optional>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "slipstream/image.h"
#include "slipstream/viewer.h"

namespace slipstream::view {

/// A box in the camera's frame of the scanner, mm.
struct Box {
  glm::vec3 low{0}, high{0};

  [[nodiscard]] glm::vec3 centre() const { return 0.5F * (low + high); }
  [[nodiscard]] float diagonal() const { return glm::length(high - low); }
};

/// The scanner's frame in the display's, and back: (x, -y, -z).
inline glm::vec3 in_display_frame(const glm::vec3& point) {
  return {point.x, -point.y, -point.z};
}

/// Turns by a drag across the picture, in shares of its height: right and down are positive.
OrbitCamera orbited(OrbitCamera camera, const glm::vec2& drag);

/// Moves so that objects at the target's distance follow a drag, in shares of the height.
OrbitCamera panned(OrbitCamera camera, const glm::vec2& drag);

/// Zooms in by wheel steps, or out if negative.
OrbitCamera zoomed(OrbitCamera camera, float steps);

/// Standard views: like the scanner's camera, from the right, from above.
enum class Viewpoint { front, side, top };
OrbitCamera looking_from(OrbitCamera camera, Viewpoint viewpoint);

/// Looks at the box's centre from where all of it is visible, at the same angles.
OrbitCamera fitted(OrbitCamera camera, const Box& box, Size picture);

/// Display's frame to the eye's.
glm::mat4 view_matrix(const OrbitCamera& camera);

/// Distances from the eye between which points are drawn, in distances of the target.
constexpr float nearest_share = 0.02F, farthest_share = 50;

/// Scanner's frame to clip coordinates.
glm::mat4 clip_matrix(const OrbitCamera& camera, Size picture);

/// Scanner's frame to clip coordinates of its image in a mirror, the plane Y = `height`.
glm::mat4 mirrored_clip_matrix(const OrbitCamera& camera, Size picture, float height);

/// Position on the picture, pixels, of a point in clip coordinates; nullopt if behind the eye.
std::optional<glm::vec2> pixel_of(const glm::vec4& clip, Size picture);

/// Pixels per millimetre at a distance of one millimetre from the eye.
float pixels_per_slope(const OrbitCamera& camera, Size picture);

}  // namespace slipstream::view
