#pragma once

#include "slipstream/base/image.h"

namespace slipstream {

/// A wrapped phase map as the methods take it.
struct WrappedCycles {
  Image<float> cycles;  ///< phase in periods, [-0.5, 0.5]; NaN where there is none
  /// Above 0, more is better; empty where nothing is known.
  Image<float> quality;

  [[nodiscard]] bool has(std::size_t pixel) const {
    return cycles.begin()[pixel] == cycles.begin()[pixel];
  }
};

/// What they give.
struct Orders {
  Image<int> order;   ///< whole periods to add
  Image<int> region;  ///< the same number where they are connected; -1 where there is no phase
};

// Each is in the file of its name.
Orders orders_by_rows(const WrappedCycles& wrapped);
Orders orders_by_flood(const WrappedCycles& wrapped);
Orders orders_by_branch_cuts(const WrappedCycles& wrapped);
Orders orders_by_regions(const WrappedCycles& wrapped);
Orders orders_by_quality(const WrappedCycles& wrapped);
Orders orders_by_least_squares(const WrappedCycles& wrapped);
Orders orders_by_flow(const WrappedCycles& wrapped);

}  // namespace slipstream
