#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "slipstream/scene.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// Where a scanner measures: the point of the camera's axis at which its projector aims, and the
/// size of the field that both fully see there.
struct WorkingVolume {
  Eigen::Vector3d centre;  ///< camera frame, mm
  double extent = 0;       ///< mm
};

WorkingVolume working_volume(const Scanner& scanner);

/// Rotation from the camera's frame to an upright device that looks along `direction`.
Eigen::Matrix3d looking_along(const Eigen::Vector3d& direction);

/// A camera beside and below a projector of 1280x800, both with lens distortion and aimed at one
/// point 600 mm away.
Scanner example_scanner(Size camera = {640, 480});

/// "board", "sphere", "boxes", "statue", "contrast", "hand", "angel", "fish".
std::vector<std::string_view> scene_names();

/// A named scene, as large as the scanner's working volume:
///   board   a flat, tilted sheet that fills the view;
///   sphere  one sphere;
///   boxes   two separate boxes side by side, one nearer than the other;
///   statue  a veined bust, partly in its own shadow, in front of a wall;
///   contrast  a sheet of reflectivity 0.02 to 1 from left to right, and a dark, glossy sphere;
///   hand    a hand that moves before a white box, see hand();
///   angel   a veined figure with thin wings, with nothing behind it;
///   fish    a painted fish in relief on a grey board.
/// Throws Error for an unknown name.
Scene scene_named(std::string_view name, const Scanner& scanner);

/// A mesh (Y up, facing +Z) in front of the scanner, scaled to its working volume, or to a largest
/// side of `size` mm if positive. Throws Error for a mesh without triangles or extent.
Scene scene_with_mesh(Mesh mesh, const Scanner& scanner, double size = 0);

/// Typical poses of a calibration board, from its frame (X right, Y down, Z away, origin at its
/// centre) to the camera's: tilted by 15 to 35 degrees, at several distances, moved towards the
/// edges of the view, but fully visible to camera and projector. Deterministic. Throws Error if a
/// sheet of `width` x `height` mm does not fit the view.
std::vector<Eigen::Isometry3d> board_poses(const Scanner& scanner, int count, double width,
                                           double height);

/// A printed picture, each pixel a square of `mm_per_pixel`, as a flat sheet for the scene. Its
/// edges are blurred by half a camera pixel, as by a good lens: single rays would snap sharp edges
/// to the pixel grid.
Body printed_sheet(const Image<std::uint8_t>& picture, double mm_per_pixel, const Scanner& scanner);

/// The sheet, badly printed on a bent board, see Physics: stretched along X, its middle nearer to
/// the camera than its left and right ends.
Body misprinted(Body sheet, const Physics& physics);

}  // namespace slipstream
