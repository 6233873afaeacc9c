#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "slipstream/cloud.h"
#include "view/scene_renderer.h"

namespace slipstream::view {

/// Owns the images to which PointImages refers.
struct MadeUpCloud {
  explicit MadeUpCloud(Size size)
      : x(size, nan), y(size, nan), z(size, nan), intensity(size, 0.0F) {}

  void put(int column, int row, float at_x, float at_y, float at_z, float grey) {
    x(column, row) = at_x;
    y(column, row) = at_y;
    z(column, row) = at_z;
    intensity(column, row) = grey;
  }
  [[nodiscard]] PointImages images() const { return {x, y, z, intensity}; }

  Image<float> x, y, z, intensity;

 private:
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
};

/// A wall at `depth`, mm, seen by a camera whose focal length in pixels equals its image width;
/// intensity 200 in the left half, 40 in the right.
inline MadeUpCloud wall(Size size, float depth) {
  MadeUpCloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const auto width = static_cast<float>(size.width);
      const float u = (static_cast<float>(column) - 0.5F * width) / width;
      const float v = (static_cast<float>(row) - 0.5F * static_cast<float>(size.height)) / width;
      cloud.put(column, row, u * depth, v * depth, depth, 2 * column < size.width ? 200 : 40);
    }
  }
  return cloud;
}

/// A cloud with a point at every pixel.
inline Cloud cloud_of(const MadeUpCloud& made_up) {
  Cloud cloud(made_up.x.size());
  cloud.x = made_up.x;
  cloud.y = made_up.y;
  cloud.z = made_up.z;
  cloud.intensity = made_up.intensity;
  std::fill(cloud.validity.begin(), cloud.validity.end(), Validity::valid);
  return cloud;
}

}  // namespace slipstream::view
