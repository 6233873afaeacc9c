#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slipstream/cloud.h"
#include "slipstream/image.h"

namespace slipstream {

/// The points that one scan measured, ready to be registered: in the frame of its camera, whose
/// centre is the origin; mm.
struct View {
  std::string name{};
  std::vector<Eigen::Vector3f> points{};
  /// Unit normals, towards the camera if it is known, else away from the points' middle.
  std::vector<Eigen::Vector3f> normals{};
  std::vector<float> sigma{};      ///< standard deviation of each point along its normal, mm
  std::vector<float> intensity{};  ///< grey levels of 255
  std::vector<Colour> colours{};   ///< empty if the view has none

  float spacing = 0;  ///< median distance of a point from its nearest neighbour, mm
  /// Whether the points are as seen from the origin, so that a point hides what lies behind it.
  bool from_origin = false;

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

/// A view of a cloud. `uncertainty`: of the cloud; null: the noise is estimated. `colours`: of each
/// pixel, or null. Leaves out points at the origin, points without enough neighbours for a normal,
/// and up to 1 % of strays outside the cone that a camera at the origin sees. Throws Error for
/// fewer than 100 points.
View view_of(const Cloud& cloud, const Uncertainty* uncertainty = nullptr, std::string name = {},
             const Image<Colour>* colours = nullptr);

}  // namespace slipstream
