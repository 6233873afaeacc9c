#pragma once

#include "simulate/ray_packet.h"
#include "simulate/surface_packet.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// The projector's pixels that light points on surfaces that face it; `lit`: whether there is one,
/// 1 or 0, `tangent2`: the squared tangent of the angle to the projector's axis.
struct LightingPixels {
  Lanes column, row, lit, tangent2, distance;
};

LightingPixels lighting_pixels(const Scanner& scanner, const Eigen::Vector3d& light,
                               const PacketSurfaces& surfaces);

/// Directions of rays through positions in a camera's picture, as ray_through. Quick where each
/// packet is near the last.
class PacketRays {
 public:
  explicit PacketRays(const Lens& lens) : lens_(lens) {}

  /// `column` and `row`: pixels. NaN where the lens model is not invertible.
  void find(const Lanes& column, const Lanes& row, LaneVectors& directions);

 private:
  Lens lens_;
  /// A direction and its image, and the change of the direction by the image.
  struct Known {
    double x = 0, y = 0, image_x = 0, image_y = 0, xx = 1, xy = 0, yx = 0, yy = 1;
  };
  Known last_;
};

/// sin(x) and cos(x).
void sines(const Lanes& x, Lanes& sine);
void cosines(const Lanes& x, Lanes& cosine);

}  // namespace slipstream
