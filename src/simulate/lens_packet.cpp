#include "simulate/lens_packet.h"

#include <algorithm>
#include <array>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulate/lens_packet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simulate/packets-inl.h"

// Plain loops over the rays of a packet, which the compiler turns into vectors of each target.
HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// The image of a direction by OpenCV's lens model, and the radial factor's derivative by r^2.
struct BentRay {
  double x, y, radial, radial_by_r2, r2;
};

HWY_INLINE BentRay bent_ray(const double* k, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double below = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  const double radial = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / below;

  const double by_r2 =
      (k[0] + 2 * k[1] * r2 + 3 * k[4] * r4 - radial * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4)) /
      below;
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + k[8] * r2 + k[9] * r4,
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + k[10] * r2 + k[11] * r4, radial,
          by_r2, r2};
}

constexpr int all_lost = -1;

/// One step of Newton's method towards the directions of images. `slopes`: xx, xy, yx, yy of the
/// inverse. Returns the number of rays that are not found yet, or `all_lost` near the end of the
/// model's invertible range.
int StepTowards(const double* k, const Lanes& image_x, const Lanes& image_y, LaneVectors& at,
                std::array<Lanes, 4>& slopes) {
  constexpr double close = 1e-9;  // the next step would be its square
  constexpr double smallest_area = 0.05, longest = 0.5;
  int missing = 0, lost = 0;

  for (int i = 0; i < packet_rays; ++i) {
    const double x = at.x[i], y = at.y[i];
    const BentRay bent = bent_ray(k, x, y);

    const double prism_x = 2 * (k[8] + 2 * k[9] * bent.r2);
    const double prism_y = 2 * (k[10] + 2 * k[11] * bent.r2);
    const double mixed = 2 * x * y * bent.radial_by_r2 + 2 * k[2] * x + 2 * k[3] * y;
    const double xx =
        bent.radial + 2 * x * x * bent.radial_by_r2 + 2 * k[2] * y + 6 * k[3] * x + x * prism_x;
    const double yy =
        bent.radial + 2 * y * y * bent.radial_by_r2 + 6 * k[2] * y + 2 * k[3] * x + y * prism_y;
    const double xy = mixed + y * prism_x, yx = mixed + x * prism_y;

    const double area = xx * yy - xy * yx;
    slopes[0][i] = yy / area, slopes[1][i] = -xy / area;
    slopes[2][i] = -yx / area, slopes[3][i] = xx / area;

    const double off_x = image_x[i] - bent.x, off_y = image_y[i] - bent.y;
    const double step_x = slopes[0][i] * off_x + slopes[1][i] * off_y;
    const double step_y = slopes[2][i] * off_x + slopes[3][i] * off_y;
    at.x[i] = x + step_x;
    at.y[i] = y + step_y;
    const double length = std::max(std::abs(step_x), std::abs(step_y));
    missing += length <= close ? 0 : 1;
    lost += (area > smallest_area) & (length < longest) ? 0 : 1;
  }

  return lost > 0 ? all_lost : missing;
}

void FindLightingPixels(const Scanner& scanner, const double* light, const PacketSurfaces& surfaces,
                        LightingPixels& pixels) {
  const double light_x = light[0], light_y = light[1], light_z = light[2];
  const Lens& lens = scanner.projector;
  const double* const k = lens.distortion.coefficients.data();
  const double* const K = lens.intrinsic.data();
  const double* const T = scanner.translation.data();
  const double most_column = lens.size.width - 0.5, most_row = lens.size.height - 0.5;

  LaneVectors point;
  turn(scanner.rotation.data(), 3, surfaces.point, point);
  for (int i = 0; i < packet_rays; ++i) {
    const double z = point.z[i] + T[2];
    const double x = (point.x[i] + T[0]) / z, y = (point.y[i] + T[1]) / z;
    const BentRay bent = bent_ray(k, x, y);
    const double column = K[0] * bent.x + K[3] * bent.y + K[6], row = K[4] * bent.y + K[7];
    pixels.column[i] = column;
    pixels.row[i] = row;
    pixels.tangent2[i] = x * x + y * y;

    const double lx = light_x - surfaces.point.x[i], ly = light_y - surfaces.point.y[i];
    const double lz = light_z - surfaces.point.z[i];
    pixels.distance[i] = std::sqrt(lx * lx + ly * ly + lz * lz);

    const double facing =
        surfaces.normal.x[i] * lx + surfaces.normal.y[i] * ly + surfaces.normal.z[i] * lz;
    const bool lit = (z > 0) & (facing > 0) & (column >= -0.5) & (column < most_column) &
                     (row >= -0.5) & (row < most_row);
    pixels.lit[i] = lit ? 1 : 0;
  }
}

void Sines(const Lanes& x, Lanes& sine) {
  sine_lanes(x, sine);
}

void Cosines(const Lanes& x, Lanes& cosine) {
  cosine_lanes(x, cosine);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(StepTowards);
HWY_EXPORT(FindLightingPixels);
HWY_EXPORT(Sines);
HWY_EXPORT(Cosines);

namespace {

bool in_field(const Lens& projector, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.x() < projector.size.width - 0.5 && pixel.y() >= -0.5 &&
         pixel.y() < projector.size.height - 0.5;
}

}  // namespace

LightingPixels lighting_pixels(const Scanner& scanner, const Eigen::Vector3d& light,
                               const PacketSurfaces& surfaces) {
  LightingPixels pixels;
  HWY_DYNAMIC_DISPATCH(FindLightingPixels)(scanner, light.data(), surfaces, pixels);

  // A tilted sensor, or a residual map.
  const Lens& lens = scanner.projector;
  const auto& k = lens.distortion.coefficients;
  if (k[12] == 0 && k[13] == 0 && lens.residual.terms.empty()) return pixels;

  for (int i = 0; i < packet_rays; ++i) {
    const Eigen::Vector3d point = in_projector_frame(scanner, surfaces.point.at(i));
    const Eigen::Vector2d pixel = project(lens, point);
    pixels.column[i] = pixel.x();
    pixels.row[i] = pixel.y();
    const bool faces = (light - surfaces.point.at(i)).dot(surfaces.normal.at(i)) > 0;
    pixels.lit[i] = point.z() > 0 && faces && in_field(lens, pixel) ? 1 : 0;
  }

  return pixels;
}

void PacketRays::find(const Lanes& column, const Lanes& row, LaneVectors& directions) {
  const Eigen::Matrix3d& K = lens_.intrinsic;
  const auto& k = lens_.distortion.coefficients;

  // 1. The images behind the lens, and the directions if the lens were linear about the last.
  Lanes image_x, image_y;
  for (int i = 0; i < packet_rays; ++i) {
    const Eigen::Vector2d shift = shift_at(lens_.residual, {column[i], row[i]});
    image_y[i] = (row[i] - shift.y() - K(1, 2)) / K(1, 1);
    image_x[i] = (column[i] - shift.x() - K(0, 2) - K(0, 1) * image_y[i]) / K(0, 0);
    const double off_x = image_x[i] - last_.image_x, off_y = image_y[i] - last_.image_y;
    directions.x[i] = last_.x + last_.xx * off_x + last_.xy * off_y;
    directions.y[i] = last_.y + last_.yx * off_x + last_.yy * off_y;
    directions.z[i] = 1;
  }
  if (lens_.distortion.is_zero()) return;

  // 2. Newton's method, a few steps.
  constexpr int most_steps = 8;
  std::array<Lanes, 4> slopes;
  int missing = k[12] == 0 && k[13] == 0 ? packet_rays : -1;
  for (int step = 0; step < most_steps && missing > 0; ++step) {
    missing = HWY_DYNAMIC_DISPATCH(StepTowards)(k.data(), image_x, image_y, directions, slopes);
  }

  if (missing == 0) {
    last_ = {directions.x[0], directions.y[0], image_x[0],   image_y[0],
             slopes[0][0],    slopes[1][0],    slopes[2][0], slopes[3][0]};
    return;
  }

  // 3. Where that fails, for a tilted sensor and at the end of the model's invertible range.
  for (int i = 0; i < packet_rays; ++i) {
    directions.set(i, ray_through(lens_, {column[i], row[i]}));
  }
  last_ = {};
}

void sines(const Lanes& x, Lanes& sine) {
  HWY_DYNAMIC_DISPATCH(Sines)(x, sine);
}

void cosines(const Lanes& x, Lanes& cosine) {
  HWY_DYNAMIC_DISPATCH(Cosines)(x, cosine);
}

}  // namespace slipstream
#endif
