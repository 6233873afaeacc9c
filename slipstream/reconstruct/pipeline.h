#pragma once

#include <optional>
#include <string>

#include "slipstream/decode/decoder.h"
#include "slipstream/decode/surface_orders.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// The order of every pixel, and the memory that finding it takes.
struct DepthOrders {
  Image<int> order{};  ///< SurfaceOrders::none where not valid
  /// `out_of_range` where there is no candidate, `doubtful_order` where there are several.
  Image<Validity> validity{};
  Image<OrderRange> possible{};
  Image<float> phase{};
  SurfaceOrders by_surfaces{};
};

/// The fringe order from the range of depth asked for (An, Hyun, Zhang 2016): along a pixel's ray
/// the nearest and the farthest depth bound the projector coordinate, and an order whose coordinate
/// lies between them is a candidate. All that is lit must lie in the range. Of frames that are
/// taken apart by their spectra each connected surface has one order, see by_possible_orders; of
/// others each pixel has that which is the only candidate.
class DepthUnwrapper {
 public:
  /// Throws Error where the range lies behind the projector at the middle pixel or, of what is no
  /// spectrum, covers a period or more there, so that little would have one candidate alone.
  explicit DepthUnwrapper(const EngineSetup& setup);

  /// `full_scale`: the largest grey level of the frames, whose levels the modulation has.
  void operator()(const Image<float>& wrapped_phase, const Image<float>& modulation,
                  double full_scale, DepthOrders& to) const;

  /// Coordinates of wrapped phases of those orders; NaN where there is none.
  template <class Real>
  void unwrap(const Image<Real>& wrapped_phase, const Image<int>& order,
              Image<Real>& coordinate) const;

  /// Gives the maps their coordinate, and says why where there is none: DepthOrders::validity.
  [[nodiscard]] Image<Validity> operator()(BasicMaps<double>& maps, double full_scale) const;

 private:
  /// Between which y lies, in periods, least first; NaN where that is not known.
  struct Bounds {
    float least = 0;
    float largest = 0;
  };

  [[nodiscard]] OrderRange possible(float phi, float modulation, const Bounds& bounds) const;

  double periods_;
  float noise_;  ///< standard deviation in periods where B is one grey level of 8 bits
  bool by_surfaces_;
  float least_modulation_;  ///< grey levels of 8 bits
  Image<Bounds> bounds_;
};

/// A scan in 3-D and in double, with what it was made from.
struct ReferenceResult {
  BasicCloud<double> cloud{};
  BasicMaps<double> maps{};
};

/// The algorithm itself, in double and stage by stage over the whole picture: every layout, any
/// frames, any lens that Triangulator takes. What the fused pass and the GPU are measured by, and
/// what stands in for them where they cannot. Read pipeline.cpp for the order of the stages.
/// Tables are built once. Thread-safe.
class ReferenceEngine {
 public:
  /// Throws Error as Engine does. `corrections` are added to the phases.
  ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections);

  // Each throws Error when the frames are not of the camera's size or not as many as the
  // strategy's. Nothing is cleaned: Engine cleans the clouds of all engines alike.
  [[nodiscard]] ReferenceResult operator()(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames) const {
    Image<Validity> order;
    return maps(frames, order);
  }
  /// The same in float, as far as it is wanted.
  void run(const FrameViews& frames, const Outputs& outputs) const;

  /// Null where no range of depth gives the fringe order.
  [[nodiscard]] const DepthUnwrapper* by_depth() const {
    return unwrap_by_depth_ ? &*unwrap_by_depth_ : nullptr;
  }
  /// See Decoder::method_for.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  /// `order`: why the range of depth gives a pixel no fringe order; empty where it gives none.
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames, Image<Validity>& order) const;

  EngineSetup setup_;
  Triangulator triangulate_;
  Decoder decode_;
  std::optional<DepthUnwrapper> unwrap_by_depth_;
};

// Stages of the pipeline that belong to no room above this one.

/// Why the frames leave a pixel out, `valid` where they do not: too dark, saturated, or of a fringe
/// order that its neighbours do not confirm; else what `order` says of it, unless that is empty.
Image<Validity> judged(const BasicMaps<double>& maps, const Image<Validity>& order,
                       const FrameViews& frames, const EngineSetup& setup);

/// The points of the pixels that are valid and whose point lies before camera and projector, in the
/// projector's field and in the range of depth. Its intensity is not set.
BasicCloud<double> triangulated(const Image<double>& coordinates, Image<Validity> validity,
                                const Triangulator& triangulate, const EngineSetup& setup);

/// How sure each point of a cloud is under noise of the scanner's variance: see
/// Engine::uncertainty. `full_scale`: of the frames.
Uncertainty uncertainty_of(const Cloud& cloud, const Maps& maps, const EngineSetup& setup,
                           double full_scale);

}  // namespace slipstream
