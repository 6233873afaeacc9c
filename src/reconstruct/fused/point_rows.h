#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/ray_blocks.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/stage_numbers.h"
#include "slipstream/cloud.h"

namespace slipstream {

struct PointStage : PointNumbers {
  std::vector<float> lens{};  ///< PlanePolynomial, last coefficient first
  std::optional<SolvedLens> solved{};
  bool limits_depth = false;  ///< `nearest` and `farthest` are not 0 and infinity
};

/// Inputs and outputs of a row of points.
struct PointRow {
  int width = 0;
  const float *E_x = nullptr, *E_y = nullptr;
  RayBlocks::Row blocks{};  ///< `described` is null without blocks
  const std::int32_t* flags = nullptr;
  const float* coordinate = nullptr;
  /// Coordinates for the consensus; null without one. With it, all three rows have a NaN before
  /// their first and after their last pixel.
  const float *above = nullptr, *below = nullptr;
  float *x = nullptr, *y = nullptr, *z = nullptr;  ///< mm; x and y are null if only depth is wanted
  Validity* validity = nullptr;
  bool past_cache = false;  ///< x, y, z are aligned to 8 floats and written past the cache
};

/// Single frequency: `row.coordinate` holds turns, NaN for dark or saturated pixels, converted by
/// `coordinate`. Ranges of blocks must end at the cut, see FusedStages::blocks.
void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row);

/// Several frequencies or a cue: `row.coordinate` holds coordinates that neighbours confirm.
void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row);

/// Applies DepthScale to a row.
void number_row(const DepthScale& scale, int width, const float* z, std::uint16_t* numbers);

/// x, y, z and intensity of the pixels to read or the points to write.
template <class Real>
struct PointValues {
  Real *x = nullptr, *y = nullptr, *z = nullptr, *intensity = nullptr;
};

/// Packs the pixels of a row that have a depth; returns how many. `room`: number of values at `to`
/// that may be overwritten. `from` may overlap `to`, but must not start before it.
std::size_t pack_row(int width, const PointValues<const float>& from, const PointValues<float>& to,
                     std::size_t room);

/// Call after writing rows past the cache, before another thread reads them.
void flush_past_cache();

}  // namespace slipstream
