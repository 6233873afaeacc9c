#include "cloud/seen_colours.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "geometry/rotation.h"

namespace slipstream::seen_colours_test {

constexpr Colour red{200, 10, 10}, green{10, 200, 10}, black{};

Lens lens_of(Size size, double focal) {
  Lens lens;
  lens.size = size;
  lens.intrinsic << focal, 0, 0.5 * size.width, 0, focal, 0.5 * size.height, 0, 0, 1;
  return lens;
}

/// The depth of a wall at 600 mm and a plate of 100 x 100 mm before it, at 500 mm, along a ray from
/// `eye` with z = 1; `on_plate` tells which.
double depth_along(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray, bool& on_plate) {
  const Eigen::Vector3d at = eye + 500 * ray;
  on_plate = std::abs(at.x()) < 50 && std::abs(at.y()) < 50;
  return on_plate ? 500 : 600;
}

TEST(SeenColours, AreThoseOfTheSurfaceThatTheOtherCameraSees) {
  const Lens camera = lens_of({160, 120}, 200);
  const Eigen::Vector3d eye(120, 10, 0);  // of the other camera

  // Colour cameras with fewer and with more pixels.
  for (const double finer : {0.7, 1.0, 3.0}) {
    const Lens other =
        lens_of({static_cast<int>(200 * finer), static_cast<int>(120 * finer)}, 200 * finer);
    Image<Colour> picture(other.size);
    for_each_pixel_in_order(other.size, [&](int column, int row) {
      bool on_plate = false;
      depth_along(eye, ray_through(other, {column, row}), on_plate);
      picture(column, row) = on_plate ? red : green;
    });

    Cloud cloud(camera.size);
    for_each_pixel_in_order(camera.size, [&](int column, int row) {
      const Eigen::Vector3d ray = ray_through(camera, {column, row});
      bool on_plate = false;
      const Eigen::Vector3d point = depth_along({0, 0, 0}, ray, on_plate) * ray;
      cloud.x(column, row) = static_cast<float>(point.x());
      cloud.y(column, row) = static_cast<float>(point.y());
      cloud.z(column, row) = static_cast<float>(point.z());
      cloud.validity(column, row) = Validity::valid;
    });
    cloud.reject(5, 5, Validity::too_dark);

    const Image<Colour> colours =
        colours_seen_by(cloud, picture, other, pose_from(Eigen::Matrix3d::Identity(), -eye));
    int hidden = 0, outside = 0, seen = 0, wrong = 0, lost = 0;
    for_each_pixel_in_order(camera.size, [&](int column, int row) {
      const Eigen::Vector3d point(cloud.x(column, row), cloud.y(column, row), cloud.z(column, row));
      const Colour colour = colours(column, row);
      if (!point.allFinite()) {
        EXPECT_EQ(colour, black);
        return;
      }

      // What the other camera sees towards the point, unless its pixel is on an edge.
      const Eigen::Vector3d there = point - eye;
      const Eigen::Vector2d pixel = project(other, there).array().round();
      if ((pixel.array() < 0).any() || pixel.x() >= other.size.width ||
          pixel.y() >= other.size.height) {
        ++outside;
        EXPECT_EQ(colour, black);
        return;
      }
      bool towards_plate = false;
      depth_along(eye, ray_through(other, pixel), towards_plate);
      const bool of_plate = point.z() < 550;
      if (towards_plate && !of_plate) {
        ++hidden;
        wrong += colour == red ? 1 : 0;
        return;
      }
      ++seen;
      wrong += colour == (of_plate ? green : red) ? 1 : 0;
      lost += colour == black ? 1 : 0;
    });

    EXPECT_GT(hidden, 300) << finer;
    EXPECT_GT(seen, 9000) << finer;
    EXPECT_LT(wrong, 80) << finer;  // pixels on the outline of the plate
    EXPECT_LT(lost, 300) << finer;
  }
}

}  // namespace slipstream::seen_colours_test
