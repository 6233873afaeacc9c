#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/geometry/ray_table.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

// The last stage of the fused pass, coordinates to points. What sinusoid_rows.h says of its
// functions holds for these.
namespace slipstream {

/// StripeGeometry and the limits of a point, in float.
struct PointStage {
  using Linear = std::array<float, 3>;  ///< of the ray: c_0 E_x + c_1 E_y + c_2

  Linear coordinate{}, depth{}, facing{}, place_constant{}, place_slope{};
  float coordinate_offset = 0, depth_offset = 0;  ///< m_14^p, m_34^p
  float unit_scale = 1, unit_offset = 0;          ///< from y to p
  float least_coordinate = 0, largest_coordinate = 1;
  bool may_leave_field = false;  ///< whether a y beyond these two can occur
  int lens_degree = 0;           ///< of `lens`; 0 where there is no distortion
  std::vector<float> lens;       ///< PlanePolynomial, last coefficient first
  std::array<float, 6> low_edge{}, high_edge{};
  float inner_low = 0, inner_high = 0;  ///< a q between them is in the field at every p
  float nearest = 0, farthest = std::numeric_limits<float>::max();
  bool limits_depth = false;  ///< the two are not these defaults
};

/// Which pixels' fringe orders are believed, see FringeOrderConsensus. By default all are.
struct ConsensusStage {
  float half_fringe = 0;
  int fewest_neighbours = 0;
  int fewest_if_doubtful = 0;
};

/// What a row of points is made of and where it goes.
struct PointRow {
  int width = 0;
  const float* E_x = nullptr;
  const float* E_y = nullptr;
  RayBlocks::Row blocks{};  ///< `described` null where there are none
  const std::int32_t* flags = nullptr;
  const float* coordinate = nullptr;
  /// The rows of coordinates above and below, for the consensus; null without one. With it all
  /// three rows have a NaN before their first and after their last pixel.
  const float* above = nullptr;
  const float* below = nullptr;
  float* x = nullptr;  ///< mm; null, as `y`, where only depth is wanted
  float* y = nullptr;
  float* z = nullptr;
  Validity* validity = nullptr;
  bool past_cache = false;  ///< x, y, z are aligned to 8 floats and written past the cache
};

/// For a single frequency: `row.coordinate` holds wrapped phases in turns, NaN where a pixel is
/// dark or saturated, which `coordinate` turns into projector coordinates. The ranges that blocks
/// describe must end at the cut, see FusedStages::blocks.
void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row);
/// For several frequencies or a cue: `row.coordinate` holds projector coordinates, which the
/// neighbours must confirm.
void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row);

/// DepthScale of a row, whose width is at least least_row_width.
void number_row(const DepthScale& scale, int width, const float* z, std::uint16_t* numbers);

/// x, y, z and intensity of pixels, or where those of points go.
template <class Real>
struct PointValues {
  Real* x = nullptr;
  Real* y = nullptr;
  Real* z = nullptr;
  Real* intensity = nullptr;
};

/// Writes those pixels of a row, whose width is at least least_row_width, one behind another that
/// have a depth, and returns how many. `room`: so many values may be overwritten there, at least as
/// many as have one. What is read may be there too, but not before it.
std::size_t pack_row(int width, const PointValues<const float>& from, const PointValues<float>& to,
                     std::size_t room);

/// After rows that were written past the cache, before another thread reads them.
void flush_past_cache();

}  // namespace slipstream
