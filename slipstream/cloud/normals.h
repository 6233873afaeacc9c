#pragma once

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// Unit surface normals of an organised cloud, towards the camera; NaN where a point or too many of
/// its neighbours are missing.
struct Normals {
  Image<float> x;
  Image<float> y;
  Image<float> z;
};

/// From the differences to the four neighbours in the picture; a neighbour farther away in depth
/// than `largest_step` times the distance between pixels at that depth counts as across an edge and
/// is left out.
Normals surface_normals(const Cloud& cloud, double largest_step = 8);

/// The same of planes laid through all points of one surface in a window, of 5x5 pixels by default,
/// so that noise shows less: for shading. `reach`: half the window's width, pixels, 1 or more.
Normals smoothed_normals(const Cloud& cloud, int reach = 2, double largest_step = 8);

}  // namespace slipstream
