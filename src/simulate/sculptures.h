#pragma once

#include "slipstream/scene.h"

namespace slipstream {

// Meshes of the named scenes: about 1 high or long, centred on the origin, Y up, facing +Z.

/// A bust with a ring in front of its chest: rounded, grooved, undercut, partly in its own shadow.
Mesh statue();

/// A praying angel with a halo, in a pleated robe: thin, ribbed wings behind a rounded body.
Mesh angel();

/// A fish in relief, head to the left: a rounded body with ribbed fins, open at the back.
Mesh fish();

/// Paint of a fish of that length, mm: a dark back, scales, bands and an eye. Reflectivity 0.3 to
/// 0.9.
Texture fish_paint(double length);

/// One end of a limb: a point and the radius around it.
struct LimbEnd {
  Eigen::Vector3d centre;
  double radius = 0;
};

/// Adds a limb with round ends whose radius changes evenly from one end to the other.
void append_limb(Mesh& mesh, const LimbEnd& from, const LimbEnd& to);

/// Adds an ellipsoid.
void append_ellipsoid(Mesh& mesh, const Eigen::Vector3d& centre, const Eigen::Vector3d& radii);

}  // namespace slipstream
