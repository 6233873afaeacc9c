#pragma once

#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "slipstream/base/size.h"

namespace slipstream::view {

/// A box in the camera's frame of the scanner, mm.
struct Box {
  glm::vec3 low{0};
  glm::vec3 high{0};

  [[nodiscard]] glm::vec3 centre() const { return 0.5F * (low + high); }
  [[nodiscard]] float diagonal() const;
};

/// From where the cloud is looked at: a place on a sphere round a target. All angles 0: as the
/// scanner's camera does, upright. The display's frame is the scanner's turned by half a turn about
/// X, so that Y is up and the cloud is seen from its front.
struct OrbitCamera {
  glm::vec3 target{0};         ///< display's frame, mm
  float distance = 1000;       ///< mm, > 0
  float azimuth = 0;           ///< rad, to the right
  float elevation = 0;         ///< rad, up; within a right angle
  float field_of_view = 0.6F;  ///< rad, from the top of the picture to its bottom
};

/// The scanner's frame in the display's, and back: (x, -y, -z).
glm::vec3 in_display_frame(const glm::vec3& point);

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

/// Scanner's frame to clip coordinates of what a mirror shows that lies in the plane Y = `height`,
/// parallel to the XZ plane.
glm::mat4 mirrored_clip_matrix(const OrbitCamera& camera, Size picture, float height);

/// Where on the picture, in pixels from its top left corner (pixel centres at integers), a point in
/// clip coordinates lies; nothing where it is behind the eye.
std::optional<glm::vec2> pixel_of(const glm::vec4& clip, Size picture);

/// How many pixels one millimetre takes at a distance of one millimetre from the eye.
float pixels_per_slope(const OrbitCamera& camera, Size picture);

}  // namespace slipstream::view
