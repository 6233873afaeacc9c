#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/mesh.h"
#include "slipstream/simulate/scene.h"

namespace slipstream {

/// Where a scanner measures: the place on the camera's axis that its projector looks at, and how
/// large a thing there both see whole.
struct WorkingVolume {
  Eigen::Vector3d centre;  ///< camera frame, mm
  double extent = 0;       ///< mm
};

WorkingVolume working_volume(const Scanner& scanner);

/// From the camera's frame to that of a device which looks along `direction`, upright as the
/// camera.
Eigen::Matrix3d looking_along(const Eigen::Vector3d& direction);

/// A camera of that size beside and below a projector of 1280x800, both with lens distortion, which
/// look at one place 600 mm away.
Scanner example_scanner(Size camera = {640, 480});

/// "board", "sphere", "boxes", "statue", "contrast".
std::vector<std::string_view> scene_names();

/// The scene of that name, as large as the scanner's working volume:
///   board   a flat sheet, tilted, that fills the view;
///   sphere  one sphere;
///   boxes   two boxes side by side, apart, one nearer than the other;
///   statue  a veined bust in partial shadow of itself before a wall;
///   contrast  a sheet of reflectivity 0.02 to 1 from left to right, and a dark, glossy sphere.
/// Throws Error for another name.
Scene scene_named(std::string_view name, const Scanner& scanner);

/// A mesh (Y up, facing +Z) before the scanner, scaled to its working volume, or so that its
/// largest side is `size` mm where that is positive. Throws Error for a mesh without triangle or
/// extent.
Scene scene_with_mesh(Mesh mesh, const Scanner& scanner, double size = 0);

/// A bust with a ring held before its chest: rounded, grooved and undercut, and in its own shadow
/// in places. About 1 high, centred on the origin, Y up, facing +Z.
Mesh statue();

}  // namespace slipstream
