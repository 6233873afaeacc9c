// Heights over a reference plane, of scans whose scanner nobody knows.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "base/statistics.h"
#include "geometry/height_calibration.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream::heights_test {

constexpr Size camera{160, 120};
constexpr double reference = 660;  ///< mm from the camera

struct MeasuredScan {
  Image<double> phase;
  Image<double> height;  ///< truth
};

MeasuredScan measured(const Scene& scene) {
  const Scanner scanner = example_scanner(camera);
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16},
                          .projector = scanner.projector.size};
  VirtualScan scan = take_scan(scanner, scene, pattern_set(sequence), photometry_named("ideal"));
  Engine engine(without_geometry(camera, scanner.projector.size), sequence);
  for (double& depth : scan.depth) depth = reference - depth;
  return {measured_coordinates(engine, scan.frames.views()), scan.depth};
}

Scene plane_at(double height) {
  Body body{.shape = Board{3000, 3000}};
  body.pose.translation().z() = reference - height;
  return {body};
}

Image<HeightCurve> calibrated(const std::vector<double>& heights) {
  std::vector<PlanePhase> planes;
  for (const double height : heights) planes.push_back({height, measured(plane_at(height)).phase});
  const HeightFit fit = fit_heights(planes);
  EXPECT_GT(fit.pixels, 0.8 * camera.width * camera.height);
  for (const double rms : fit.rms) EXPECT_LT(rms, 0.4);
  return fit.curves;
}

/// The share of errors below which they are, mm.
double error_of(const Image<HeightCurve>& curves, const Scene& scene, double share) {
  const MeasuredScan scan = measured(scene);
  const Image<float> found = heights(curves, scan.phase);
  std::vector<double> errors;
  for (std::size_t i = 0; i < found.pixel_count(); ++i) {
    const double error = std::abs(found.begin()[i] - scan.height.begin()[i]);
    if (!std::isnan(error)) errors.push_back(error);
  }
  EXPECT_GT(errors.size(), 0.85 * static_cast<double>(finite_values(scan.phase).size()));
  return quantile(errors, share);
}

TEST(Heights, AreThoseOfPlanesAndSpheres) {
  const Image<HeightCurve> three = calibrated({0, 90, 180}),
                           many = calibrated({0, 45, 90, 135, 180});
  const Scene sphere = scene_named("sphere", example_scanner(camera));
  for (const auto& [curves, most] : {std::pair(&three, 0.35), {&many, 0.25}}) {
    for (const double height : {30., 115., 178.}) {
      EXPECT_LT(error_of(*curves, plane_at(height), 0.5), most) << height;
    }
    EXPECT_LT(error_of(*curves, sphere, 0.5), most);
    EXPECT_LT(error_of(*curves, sphere, 0.99), 5 * most);
  }
}

TEST(Heights, AreNoneWithoutLight) {
  const MeasuredScan sphere = measured(scene_named("sphere", example_scanner(camera)));
  for (std::size_t i = 0; i < sphere.phase.pixel_count(); ++i) {
    if (std::isnan(sphere.height.begin()[i])) EXPECT_TRUE(std::isnan(sphere.phase.begin()[i]));
  }
  EXPECT_GT(finite_values(sphere.phase).size(), 1000U);
}

}  // namespace slipstream::heights_test
