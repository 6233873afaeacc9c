#pragma once

#include <span>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/measure.h"

namespace slipstream {

/// One or two spheres of known size, wherever in an organised cloud they stand: each is looked for
/// where most points put its centre, a radius below them along their normals, and fitted with a
/// free radius to the points there. In the order of `radii` (mm, above 0), or the other where that
/// fits them better. Throws Error where no sphere of such a size, or too little of it, is seen.
std::vector<FittedSphere> find_spheres(const Cloud& cloud, std::span<const double> radii);

/// Whether the ray from the camera through a point meets the sphere at no more than `widest_angle`
/// (rad) from its normal, however far from the sphere the point lies: what is wrong there belongs
/// to the sphere's form.
bool is_on_cap(const FittedSphere& sphere, const Eigen::Vector3d& point, double widest_angle);

}  // namespace slipstream
