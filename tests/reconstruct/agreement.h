// How far the fused pass and the reference engine agree on a scan.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

#include "decode/phase_decoder.h"
#include "geometry/triangulator.h"
#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream {

inline constexpr double depth_bound = 1e-5;  // of the depth
inline constexpr double gap =
    0.1;  // of the field, between a stripe and its ray's coordinate at infinity

inline double coordinate_at_infinity(const Scanner& scanner, Axis axis, int column, int row) {
  const ProjectionMatrices matrices = projection_matrices(scanner, axis);
  const Eigen::Vector3d ray = ray_through(scanner.camera, {column, row});
  return matrices.projector_coordinate.head<3>().dot(ray) /
         matrices.projector_depth.head<3>().dot(ray);
}

/// As coordinate_at_infinity.
inline double undistorted_coordinate(const Scanner& scanner, Axis axis,
                                     const Eigen::Vector3d& point) {
  const ProjectionMatrices matrices = projection_matrices(scanner, axis);
  return matrices.projector_coordinate.dot(point.homogeneous()) /
         matrices.projector_depth.dot(point.homogeneous());
}

struct Agreement {
  std::size_t points = 0;
  std::size_t other_validity = 0;
  std::size_t other_intensity = 0;  ///< of the same validity
  double worst = 0;                 ///< relative error of depth where the gap is kept
};

inline Agreement compare(const Scanner& scanner, Axis axis, const Cloud& cloud,
                         const ReferenceResult& exact) {
  Agreement agreement;
  for (int row = 0; row < cloud.z.height(); ++row) {
    for (int column = 0; column < cloud.z.width(); ++column) {
      const Validity validity = exact.cloud.validity(column, row);
      const float z = cloud.z(column, row);
      EXPECT_EQ(std::isfinite(z), cloud.validity(column, row) == Validity::valid);
      if (cloud.validity(column, row) != validity) {
        ++agreement.other_validity;
        continue;
      }
      const float difference = cloud.intensity(column, row) - exact.cloud.intensity(column, row);
      agreement.other_intensity += std::abs(difference) <= 1e-3F ? 0 : 1;
      if (validity != Validity::valid) continue;
      ++agreement.points;
      const double y = undistorted_coordinate(
          scanner, axis,
          {exact.cloud.x(column, row), exact.cloud.y(column, row), exact.cloud.z(column, row)});
      if (std::abs(coordinate_at_infinity(scanner, axis, column, row) - y) < gap) continue;
      const double depth = exact.cloud.z(column, row);
      agreement.worst =
          std::max({agreement.worst, std::abs(z / depth - 1),
                    std::abs(cloud.x(column, row) - exact.cloud.x(column, row)) / depth,
                    std::abs(cloud.y(column, row) - exact.cloud.y(column, row)) / depth});
    }
  }
  return agreement;
}

/// The points by the equations in double, whatever the settings ask for.
inline ReferenceResult by_equations(EngineSetup setup, const FrameViews& frames,
                                    const PhaseCorrections& corrections = {}) {
  setup.settings.phase_method = PhaseMethod::equation;
  return ReferenceEngine(setup, corrections)(frames);
}

/// Of the fused pass with known points.
inline Agreement agreement_with(const ReferenceResult& exact, const EngineSetup& setup,
                                const FrameViews& frames,
                                const PhaseCorrections& corrections = {}) {
  const auto fused = FusedEngine::make(setup, corrections);
  if (!fused) {
    ADD_FAILURE() << "no fused pass";
    return {};
  }

  Cloud cloud;
  FusedMemory memory;
  (*fused)(frames, {.cloud = &cloud}, memory);
  return compare(setup.scanner, setup.sequence.axis, cloud, exact);
}

inline Agreement agreement_on(const EngineSetup& setup, const FrameViews& frames,
                              const PhaseCorrections& corrections = {}) {
  return agreement_with(by_equations(setup, frames, corrections), setup, frames, corrections);
}

inline FrameSet statue_frames(const Scanner& scanner, const Strategy& strategy, Axis axis,
                              Photometry photometry = {.ambient = 5, .noise_variance = 1.55}) {
  return scan_of_scene("statue", scanner, pattern_set(strategy, axis), photometry).frames;
}

/// For clouds as they are computed, not cleaned.
inline EngineSetup setup_of(const Scanner& scanner, const Strategy& strategy, Axis axis,
                            ReconstructSettings settings = {}) {
  settings.clean = CleanSettings::none();
  return {scanner, {.strategy = strategy, .axis = axis}, settings};
}

}  // namespace slipstream
