#pragma once

#include <string_view>

#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// Where a scanner measures: the place on the camera's axis that its projector looks at, and the
/// size of what both see whole there.
struct WorkingVolume {
  Eigen::Vector3d centre;  ///< camera frame, mm
  double extent = 0;       ///< mm
};

WorkingVolume working_volume(const Scanner& scanner);

/// From the camera's frame to that of an upright device that looks along `direction`.
Eigen::Matrix3d looking_along(const Eigen::Vector3d& direction);

/// A camera beside and below a projector of 1280x800, both with lens distortion, which look at one
/// place 600 mm away.
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

/// A mesh (Y up, facing +Z) before the scanner, scaled to its working volume, or if positive to a
/// largest side of `size` mm. Throws Error for a mesh without triangle or extent.
Scene scene_with_mesh(Mesh mesh, const Scanner& scanner, double size = 0);

/// A bust with a ring before its chest: rounded, grooved, undercut, partly in its own shadow. About
/// 1 high, centred on the origin, Y up, facing +Z.
Mesh statue();

/// Poses of a flat sheet, its frame (X right, Y down, Z away, origin at its middle) to the
/// camera's, as a person holds a calibration board: tilted by 15 to 35 degrees, nearer and farther,
/// moved towards the edges of the view, but seen whole by camera and projector. The same arguments
/// give the same poses. Throws Error where a sheet of `width` x `height` mm does not fit the view.
std::vector<Eigen::Isometry3d> board_poses(const Scanner& scanner, int count, double width,
                                           double height);

/// A printed picture, each pixel a square of `mm_per_pixel`, as a flat sheet for the scene. Edges
/// are half a camera pixel soft in the working volume, as by a good lens: single rays would put
/// sharp ones on the pixel grid.
Body printed_sheet(const Image<std::uint8_t>& picture, double mm_per_pixel, const Scanner& scanner);

/// The sheet as a careless print on a board that is not flat, see Physics: stretched along its X,
/// its middle nearer to the camera than its left and right ends.
Body misprinted(Body sheet, const Physics& physics);

}  // namespace slipstream
