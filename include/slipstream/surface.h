#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "slipstream/cloud.h"

namespace slipstream {

/// Unit surface normals of an organised cloud, towards the camera; NaN if a point or too many of
/// its neighbours are missing.
struct Normals {
  Image<float> x, y, z;
};

/// The normals in the frame that a cloud was moved to.
void move_to_frame(Normals& normals, const FramePose& pose);

/// The points of a model with their normals, in one row, in the object's frame.
struct ModelPoints {
  Cloud cloud;
  Normals normals;
};

/// Computed from the differences to the four neighbours, except across edges: steps in depth of
/// more than eight times the distance between pixels.
Normals surface_normals(const Cloud& cloud);

/// Normals averaged over 5x5 pixels to reduce noise, of unit length; NaN without a point.
Normals smoothed_normals(const Cloud& cloud);

/// Brightness of each point under a light over the viewer's left shoulder: 0.3 if turned away, 1 if
/// facing it, in between if the slope is unknown. Uses normals averaged over 5x5 pixels, to show
/// the form without the noise of depth; where noise turns them every way, the slope counts as
/// unknown. A cloud of one row is a list of points in the camera's frame.
Image<float> shading(const Cloud& cloud);

/// A triangle mesh of a cloud's points, in the camera's frame, textured with the camera's picture.
struct Surface {
  std::vector<Eigen::Vector3f> vertices{};  ///< mm; each is a corner of a triangle
  std::vector<float> intensity{};           ///< of each vertex, as in the cloud
  /// Texture coordinates: right and down from the picture's upper left corner, 0 to 1.
  std::vector<Eigen::Vector2f> texture{};
  /// Indices of their corners, counter-clockwise as seen by the camera.
  std::vector<std::array<std::uint32_t, 3>> triangles{};
  Image<std::uint8_t> picture{};
  /// Colours of each vertex and of the picture, sRGB; empty without a colour camera.
  std::vector<Colour> colour{};
  Image<Colour> colour_picture{};
  std::shared_ptr<const FramePose> frame{};  ///< as Cloud::frame
};

/// As for a cloud.
void move_to_frame(Surface& surface, const FramePose& pose);

/// Triangulates blocks of 2x2 neighbouring points: two triangles, divided along the smaller step in
/// depth, or one if a point is missing. Depths of a triangle's corners differ by at most
/// `largest_step` times the distance between their rays.
Surface surface_of(const Cloud& cloud, double largest_step = 8);

}  // namespace slipstream
