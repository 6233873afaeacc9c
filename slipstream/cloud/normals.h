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
/// than eight times the distance between pixels at that depth counts as across an edge and is left
/// out.
Normals surface_normals(const Cloud& cloud);

/// Their mean over 5x5 pixels, of unit length, so that noise shows less; NaN where the pixel itself
/// has no point.
Normals smoothed_normals(const Cloud& cloud);

/// How bright each point of an organised cloud looks under a light over the viewer's left shoulder:
/// 0.3 for what is turned away, 1 for what faces it, in between where the slope is not known. From
/// smoothed_normals, so that the form shows and the noise of depth does
/// not.
Image<float> shading(const Cloud& cloud);

}  // namespace slipstream
