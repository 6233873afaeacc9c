// Numbers of the stages, shared by the row kernels and the shaders: C++ and GLSL.
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

/// Turns to projector coordinates in the field, see coordinate_in_field. Quotients are computed by
/// `placing`, because division on a device is not exact.
struct CoordinateStage {
  float scale;           ///< 1 / f
  float period;          ///< the coordinate is known up to multiples of this
  float cut;             ///< coordinates are brought into [cut, cut + period)
  float fields_of_turn;  ///< scale / period
  float cut_fields;      ///< cut / period
};

struct SinusoidNumbers {
  int steps SLIPSTREAM_DEFAULT(3);
  float sine_weight SLIPSTREAM_DEFAULT(1);  ///< tan of the wrapped phase is this times V / U
  float sine_square SLIPSTREAM_DEFAULT(1);  ///< square of `sine_weight`
  /// From sqrt(U^2 + sine_square V^2) to grey levels.
  float modulation_scale SLIPSTREAM_DEFAULT(1);
  /// From the measured turn to the band's: times direction (1 or -1), then plus offset.
  float direction SLIPSTREAM_DEFAULT(1), offset SLIPSTREAM_DEFAULT(0);
};

/// Limits that depend on the camera's bits and the settings.
struct SinusoidLimits {
  float least_square SLIPSTREAM_DEFAULT(0);  ///< modulation threshold, as U^2 + sine_square V^2
  float mean_scale SLIPSTREAM_DEFAULT(1);    ///< from the (weighted) sum of frames to the mean
  int full_scale SLIPSTREAM_DEFAULT(std::numeric_limits<int>::max());  ///< least saturated level
};

/// Fringe orders from a lower frequency, Eq. (1.17).
struct UnwrapStage {
  float ratio SLIPSTREAM_DEFAULT(16);  ///< f_h / f_l
  float largest_doubt SLIPSTREAM_DEFAULT(0.25F);
  float open SLIPSTREAM_DEFAULT(0);         ///< a doubt up to this counts as 0
  float doubt_scale SLIPSTREAM_DEFAULT(1);  ///< of the rest of the doubt
  CoordinateStage coordinate;               ///< of f_h
};

struct CodeNumbers {
  int gray SLIPSTREAM_DEFAULT(1);
  int base SLIPSTREAM_DEFAULT(0);      ///< bit that the others are XORed with; 0: none
  int others SLIPSTREAM_DEFAULT(0);    ///< bits that are XORed
  float stripe SLIPSTREAM_DEFAULT(1);  ///< stripe width, fields
};

struct CueNumbers {
  /// R = gain (channel - ambient) / B_1 - offset, (3.58), (3.74).
  float gain, offset;
  float shade;  ///< what R adds to the mean, relative to B_1: c_2 / c_1 of a cue in the mean, or 0
  float periods;  ///< f_h
  float largest_doubt;
};

/// Limits of a cue that depend on the camera's bits.
struct CueLimits {
  float ambient;        ///< beta, grey levels of the frames
  float lit_square;     ///< U^2 + sine_square V^2 up to which a pixel is `dim`
  float voting_square;  ///< the same, below which a pixel does not vote on its neighbours' orders
};

struct OrderCostNumbers {
  CueForm form;
  float share, cue_share;  ///< c_1, c_2
  float constant_light, steady, component_variance, cue_variance;
  float periods;  ///< f_h
  float margin;   ///< how far outside the field a coordinate may lie: CueEvidence::near_field
};

/// Which pixels' fringe orders are trusted, see FringeOrderConsensus. Default: all.
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
  int lens_degree;  ///< of PointStage::lens; 0 without distortion, -1 if it is solved
  EdgeTerms low_edge, high_edge;
  float inner_low, inner_high;  ///< every q between them is in the field at every p
  float nearest, farthest;
  int may_leave_field SLIPSTREAM_DEFAULT(0);  ///< whether y can exceed its two limits
};

#ifdef __cplusplus
inline CoordinateStage placing(float scale, float period, float cut) {
  return {scale, period, cut, scale / period, cut / period};
}

}  // namespace slipstream
#endif
