#pragma once

#include <cmath>
#include <cstddef>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// Sum of squares, and of how many.
struct Squares {
  double sum = 0;
  int count = 0;

  void add(double square) {
    sum += square;
    ++count;
  }
  void add(const Squares& other) {
    sum += other.sum;
    count += other.count;
  }
  /// 0 of none.
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

/// RMS distances between corners as seen and as predicted, pixels of the device; `stereo` over the
/// corners of both devices together.
struct ReprojectionRms {
  double camera = 0;
  double projector = 0;
  double stereo = 0;
};

/// The same distances, squared.
struct Reprojection {
  Squares camera, projector;

  void add(const Reprojection& other);
  [[nodiscard]] ReprojectionRms rms() const;
};

/// Of a view that is pose `v` of the state.
Reprojection reprojection(const BoardView& view, const BundleState& state, std::size_t v);

}  // namespace slipstream
