#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/measure.h"
#include "view/orbit_camera.h"

namespace slipstream::view {

/// Projection of a cloud onto its drawn picture.
struct CloudOnPicture {
  const Cloud& cloud;
  const Uncertainty* uncertainty = nullptr;  ///< that cloud's; null if unknown
  glm::mat4 clip{1};                         ///< from the scanner's frame
  Size picture;
  const FramePose* frame = nullptr;  ///< of coordinates told to the user; null: the cloud's
};

/// The point nearest to the eye within `reach` pixels of a place on the picture.
std::optional<MeasuredPoint> point_under(const CloudOnPicture& shown, const glm::vec2& place,
                                         float reach);

/// The visible points in a rectangle of the picture, given by two opposite corners.
std::vector<MeasuredPoint> points_between(const CloudOnPicture& shown, const glm::vec2& corner,
                                          const glm::vec2& opposite);

/// Measurements made with the mouse.
struct Measured {
  std::vector<MeasuredPoint> ends;  ///< ends of a distance, at most two
  std::vector<std::string> lines;   ///< text shown to the user
};

/// Adds an end of a distance: the second completes it, the third starts a new one. `frame`: as
/// CloudOnPicture's.
void add_end(Measured& measured, const MeasuredPoint& point, const FramePose* frame = nullptr);

/// Replaces the measurement by the plane and the sphere through these points.
void fit_shapes(Measured& measured, std::span<const MeasuredPoint> points,
                const FramePose* frame = nullptr);

/// "X 1.23 Y 4.56 Z 789.01 mm, sigma of Z 0.04 mm"; with a frame "..., in robot_base", where sigma
/// is along the ray.
std::string text_of(const MeasuredPoint& point, const FramePose* frame = nullptr);

}  // namespace slipstream::view
