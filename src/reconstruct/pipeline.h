#pragma once

#include <optional>
#include <string>

#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "decode/surface_orders.h"
#include "geometry/triangulator.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Fringe orders of all pixels, with the buffers used to find them.
struct DepthOrders {
  Image<int> order{};  ///< SurfaceOrders::none where not valid
  /// `out_of_range` if no order lies in the depth range, `doubtful_order` if it is ambiguous.
  Image<Validity> validity{};
  Image<OrderRange> possible{};
  Image<float> phase{};
  SurfaceOrders by_surfaces{};
};

/// Finds fringe orders from the depth range (An, Hyun, Zhang 2016). Along a pixel's ray, the
/// nearest and farthest depth bound the projector coordinate; every order whose coordinate lies
/// between them is a candidate. All lit surfaces must lie in the range. Spectral strategies get one
/// order per connected surface, see by_possible_orders; others need a single candidate.
class DepthUnwrapper {
 public:
  /// Throws Error if, at the middle pixel, the range begins behind the projector or, for strategies
  /// that are not spectral, spans a period or more: few pixels would then have a single candidate.
  explicit DepthUnwrapper(const EngineSetup& setup);

  /// `full_scale`: largest grey level of the frames; `modulation` is in the same grey levels.
  void operator()(const Image<float>& wrapped_phase, const Image<float>& modulation,
                  double full_scale, DepthOrders& to) const;

  /// Coordinates from wrapped phases and orders; NaN where the order is SurfaceOrders::none.
  template <class Real>
  void unwrap(const Image<Real>& wrapped_phase, const Image<int>& order,
              Image<Real>& coordinate) const;

  /// Sets the coordinates of `maps`; returns why a pixel has none, see DepthOrders::validity.
  [[nodiscard]] Image<Validity> operator()(BasicMaps<double>& maps, double full_scale) const;

 private:
  /// Range of y along a pixel's ray, periods; NaN if unknown.
  struct Bounds {
    float least = 0;
    float largest = 0;
  };

  [[nodiscard]] OrderRange possible(float phi, float modulation, const Bounds& bounds) const;

  double periods_;
  float noise_;  ///< standard deviation, periods, where B is one grey level of 8 bits
  bool by_surfaces_;
  float least_modulation_;  ///< grey levels of 8 bits
  Image<Bounds> bounds_;
};

/// Cloud of a scan in double precision, with the maps it was made from.
struct ReferenceResult {
  BasicCloud<double> cloud{};
  BasicMaps<double> maps{};
};

/// Reference implementation: double precision, stage by stage over the whole image, for every
/// layout, frame format and lens that Triangulator supports. The fused pass and the GPU are tested
/// against it, and it replaces them where they cannot be used. Read pipeline.cpp for the stages.
/// Builds its tables once. Thread-safe.
class ReferenceEngine {
 public:
  /// Throws Error as Engine's constructor does. `corrections` are added to the phases.
  ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections);

  // Both throw Error if the size or number of frames is wrong. Engine cleans the cloud.
  [[nodiscard]] ReferenceResult operator()(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames) const {
    Image<Validity> order;
    return maps(frames, order);
  }

  /// Computes the requested outputs, converted to float.
  void run(const FrameViews& frames, const Outputs& outputs) const;

  /// Null if the fringe order does not come from the depth range.
  [[nodiscard]] const DepthUnwrapper* by_depth() const {
    return unwrap_by_depth_ ? &*unwrap_by_depth_ : nullptr;
  }

  /// See Decoder::method_for.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  /// `order`: why the depth range gives a pixel no fringe order; no pixels if it is not used.
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames, Image<Validity>& order) const;

  EngineSetup setup_;
  Triangulator triangulate_;
  Decoder decode_;
  std::optional<DepthUnwrapper> unwrap_by_depth_;
};

// Pipeline stages defined in points.cpp.

/// Why each pixel is rejected, or `valid`: too dark, saturated, a fringe order that the neighbours
/// do not confirm, or the reason in `order` unless that is empty.
Image<Validity> judged(const BasicMaps<double>& maps, const Image<Validity>& order,
                       const FrameViews& frames, const EngineSetup& setup);

/// Why a point at this projector coordinate is rejected, or `valid`: behind the camera or the
/// projector, outside the projector's field or outside the depth range. `point`: camera's frame,
/// mm.
Validity validity_of(double coordinate, const Eigen::Vector3d& point, const EngineSetup& setup);

/// Points of the valid pixels, without intensity. Rejects points behind the camera or the
/// projector, outside the projector's field or outside the depth range.
BasicCloud<double> triangulated(const Image<double>& coordinates, Image<Validity> validity,
                                const Triangulator& triangulate, const EngineSetup& setup);

/// See Engine::uncertainty. `full_scale`: largest grey level of the frames.
Uncertainty uncertainty_of(const Cloud& cloud, const Maps& maps, const EngineSetup& setup,
                           double full_scale);

}  // namespace slipstream
