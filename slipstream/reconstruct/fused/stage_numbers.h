// Numbers of the stages as the row kernels and the shaders read them: C++ and GLSL.
#ifdef __cplusplus
#pragma once

#include <array>
#include <limits>

#define SLIPSTREAM_DEFAULT(value) = value

namespace slipstream {

using RayTerms = std::array<float, 3>;
using EdgeTerms = std::array<float, 6>;
/// The reference of a cue: linear, cos(pi y), or a sinusoid of one period.
enum class CueForm : int { none, linear, cosine, circle };
#else
#define SLIPSTREAM_DEFAULT(value)
#define RayTerms float[3]
#define EdgeTerms float[6]
#define CueForm int
const int linear = 1, cosine = 2, circle = 3;
#endif

/// From turns to projector coordinates in the field, see coordinate_in_field. A device's own
/// quotients are not exact: see `placing`.
struct CoordinateStage {
  float scale;           ///< 1 / f
  float period;          ///< the coordinate is known up to multiples of it
  float cut;             ///< coordinates are brought into [cut, cut + period)
  float fields_of_turn;  ///< scale / period
  float cut_fields;      ///< cut / period
};

struct SinusoidNumbers {
  int steps SLIPSTREAM_DEFAULT(3);
  float sine_weight SLIPSTREAM_DEFAULT(1);  ///< tan of the wrapped phase is this times V / U
  float sine_square SLIPSTREAM_DEFAULT(1);  ///< its square
  /// From the root of U^2 + sine_square V^2 to grey levels.
  float modulation_scale SLIPSTREAM_DEFAULT(1);
  /// From the turn so found to that of the band: direction 1 or -1, then offset; as found where
  /// neither is set.
  float direction SLIPSTREAM_DEFAULT(1), offset SLIPSTREAM_DEFAULT(0);
};

/// What depends on the camera's bits and on the settings.
struct SinusoidLimits {
  float least_square SLIPSTREAM_DEFAULT(0);  ///< of U^2 + sine_square V^2: the modulation threshold
  float mean_scale SLIPSTREAM_DEFAULT(1);    ///< from the sum of the frames or `means` to the mean
  int full_scale SLIPSTREAM_DEFAULT(std::numeric_limits<int>::max());  ///< saturated from here on
};

/// Fringe orders by a lower frequency, Eq. (1.17).
struct UnwrapStage {
  float ratio SLIPSTREAM_DEFAULT(16);  ///< f_h / f_l
  float largest_doubt SLIPSTREAM_DEFAULT(0.25F);
  float open SLIPSTREAM_DEFAULT(0);         ///< of the doubt: so much means none
  float doubt_scale SLIPSTREAM_DEFAULT(1);  ///< of what is left of it
  CoordinateStage coordinate;               ///< of f_h
};

struct CodeNumbers {
  int gray SLIPSTREAM_DEFAULT(1);
  int base SLIPSTREAM_DEFAULT(0);      ///< the bit that the others are exclusive-or with; 0: none
  int others SLIPSTREAM_DEFAULT(0);    ///< those
  float stripe SLIPSTREAM_DEFAULT(1);  ///< its width, fields
};

struct CueNumbers {
  /// R = gain (channel - ambient) / B_1 - offset, (3.58), (3.74).
  float gain, offset;
  float shade;    ///< c_2 / c_1: what R adds to the mean, over B_1
  float periods;  ///< f_h
  float largest_doubt;
};

/// What depends on the camera's bits, beside SinusoidLimits.
struct CueLimits {
  float ambient;        ///< beta, grey levels of the frames
  float lit_square;     ///< of U^2 + sine_square V^2: up to it a pixel is `dim`
  float voting_square;  ///< likewise: below it a pixel has no say in its neighbours' orders
};

struct OrderCostNumbers {
  CueForm form;
  float share, cue_share;  ///< c_1, c_2
  float constant_light, steady, component_variance, cue_variance;
  float periods;  ///< f_h
  float margin;   ///< how far past the field a coordinate may lie: CueEvidence::near_field
};

/// Which pixels' fringe orders are believed, see FringeOrderConsensus. By default all are.
struct ConsensusStage {
  float half_fringe;
  int fewest_neighbours, fewest_if_doubtful;
};

/// StripeGeometry and the limits of a point, in float. RayTerms: c_0 E_x + c_1 E_y + c_2.
struct PointNumbers {
  RayTerms coordinate, depth, facing, place_constant, place_slope;
  float coordinate_offset, depth_offset;  ///< m_14^p, m_34^p
  float unit_scale, unit_offset;          ///< from y to p
  float least_coordinate, largest_coordinate;
  int lens_degree;  ///< of PointStage::lens; 0 where there is no distortion
  EdgeTerms low_edge, high_edge;
  float inner_low, inner_high;  ///< a q between them is in the field at every p
  float nearest, farthest;
  int may_leave_field SLIPSTREAM_DEFAULT(0);  ///< whether a y beyond its two limits can occur
};

#ifdef __cplusplus
inline CoordinateStage placing(float scale, float period, float cut) {
  return {scale, period, cut, scale / period, cut / period};
}

}  // namespace slipstream
#endif
