#pragma once

#include <optional>

#include "slipstream/base/image.h"
#include "slipstream/geometry/lens.h"

namespace slipstream {

/// E_x, E_y of Liu 2010, Eqs. (2.30), (2.31), in the camera's own frame, where F_x = F_y = 0: the
/// ray through each pixel is (E_x, E_y, 1) Z. Camera distortion included. All of the third form's
/// other tables are functions of these two and of constants: see StripeGeometry.
struct RayTable {
  Image<float> E_x;
  Image<float> E_y;
};

/// Exact at every eighth pixel and cubic between, which takes 640x480 a few milliseconds; exact at
/// every pixel where the cubic would miss a ray by more than 1e-7, as in small pictures. None where
/// some pixel has no ray.
std::optional<RayTable> ray_table(const Lens& camera);

}  // namespace slipstream
