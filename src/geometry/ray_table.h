#pragma once

#include <optional>

#include "slipstream/scanner.h"

namespace slipstream {

/// E_x, E_y of Liu 2010, Eqs. (2.30), (2.31), in the camera's own frame, where F_x = F_y = 0: the
/// ray through each pixel is (E_x, E_y, 1) Z. Includes camera distortion. The other tables of the
/// third form are functions of these two and of constants: see StripeGeometry.
struct RayTable {
  Image<float> E_x, E_y;
};

/// Exact at every eighth pixel and cubic in between, a few milliseconds for 640x480; exact
/// everywhere if the cubic would be off by more than 1e-7, as in small images. nullopt if the lens
/// model cannot be inverted over the picture.
std::optional<RayTable> ray_table(const Lens& camera);

}  // namespace slipstream
