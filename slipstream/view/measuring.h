#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "slipstream/base/size.h"
#include "slipstream/cloud/measure.h"

namespace slipstream::view {

/// How a cloud lies on the picture that is drawn of it.
struct CloudOnPicture {
  const Cloud& cloud;
  const Uncertainty* uncertainty = nullptr;  ///< of that cloud; null where not known
  glm::mat4 clip{1};                         ///< from the scanner's frame
  Size picture;
};

/// Of the points drawn within `reach` pixels of a place on the picture the one nearest to the eye.
std::optional<MeasuredPoint> point_under(const CloudOnPicture& shown, const glm::vec2& place,
                                         float reach);

/// The points drawn in a rectangle of the picture between two opposite corners.
std::vector<MeasuredPoint> points_between(const CloudOnPicture& shown, const glm::vec2& corner,
                                          const glm::vec2& opposite);

/// What was measured with the mouse.
struct Measured {
  std::vector<MeasuredPoint> ends;  ///< of a distance, two at most
  std::vector<std::string> lines;   ///< for people
};

/// Another end of a distance: the second one completes it, the third one begins anew.
void add_end(Measured& measured, const MeasuredPoint& point);

/// The plane and the sphere of these points, in place of what was measured before.
void fit_shapes(Measured& measured, std::span<const MeasuredPoint> points);

/// "X 1.23 Y 4.56 Z 789.01 mm, sigma of Z 0.04 mm".
std::string text_of(const MeasuredPoint& point);

}  // namespace slipstream::view
