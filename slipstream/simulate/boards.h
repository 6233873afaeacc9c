#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/virtual_scanner.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// Poses of a flat sheet, its frame (X right, Y down, Z away, origin at its middle) to the
/// camera's, as a person would hold a calibration board: tilted by 15 to 35 degrees this way and
/// that, nearer and farther, moved towards the edges of the view, but always seen whole by camera
/// and projector. The same arguments give the same poses. Throws Error where a sheet of `width` x
/// `height` mm does not fit into the scanner's view.
std::vector<Eigen::Isometry3d> board_poses(const Scanner& scanner, int count, double width,
                                           double height);

/// A printed picture, each pixel a square of `mm_per_pixel`, as a flat sheet for the scene. Its
/// edges are as soft as a good lens makes them, half a camera pixel where the scanner's devices
/// look at one place: without that, single rays would put edges where the pixel grid is.
Body printed_sheet(const Image<std::uint8_t>& picture, double mm_per_pixel, const Scanner& scanner);

/// The sheet as a careless print on a board that is not flat, see Physics: stretched along its X,
/// its middle nearer to the camera than its left and right ends.
Body misprinted(Body sheet, const Physics& physics);

/// What a camera sees of a sheet that somebody holds still for `still_cycles` in each pose and
/// moves on within one, while a projector shows the patterns of all sets, one set after the other,
/// over and over: the last pose is followed by the first. One cycle of the last pose is enough of
/// it. Of a pose each frame is rendered once. `rendered` is called after each pose. Throws Error
/// for less than one pose or cycle, and as virtual_frames.
Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered);

}  // namespace slipstream
