#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/reconstruct/folded_phase.h"

// The stages of the fused pass, a row of pixels at a time, in float, compiled once for each vector
// target and chosen at run time. They check nothing: rows are at least `least_row_width` wide.
namespace slipstream {

/// Lanes of the widest vectors; a row's last vector overlaps the one before it.
inline constexpr int least_row_width = 16;

/// What is known of a pixel between the stages; none set is a measured pixel.
enum PixelFlag : std::int32_t {
  dark = 1,            ///< a modulation below the threshold
  saturated = 2,       ///< a frame at full scale, where such pixels are dropped
  doubtful_order = 4,  ///< low and high frequency disagree by more than the consensus lets pass
  dim = 8,  ///< a modulation within the noise: nobody asks such a neighbour for his order
};

/// How the N frames of one sinusoid become a phase. U = sum u_n I_n and V = sum v_n I_n stand for
/// the cosine and sine sums of Liu 2010, Eqs. (1.5), (1.6): the integers of Eqs. (2.1)-(2.3) for
/// N = 3, 4, 6, numbers a + b sqrt(5) of integers for N = 5, else the sums themselves, in double.
struct SinusoidStage {
  int steps = 3;
  std::vector<double> cosines{};  ///< 2/N cos(2 pi n / N); for N above 6
  std::vector<double> sines{};
  float sine_weight = 1;       ///< of V against U
  float sine_square = 1;       ///< its square
  float modulation_scale = 1;  ///< from the root of U^2 + sine_square V^2 to grey levels
  FoldedPhase folded{};        ///< the corrected phase; empty where there is none or no such form
  /// A PhaseCorrection in turns, as an odd polynomial of r, how far N turns are from a whole one:
  /// the coefficients of r^19, r^17, ..., r. The correction of a small gamma is one. Empty where
  /// there is no correction, or only the table below says it.
  static constexpr std::size_t wave_terms = 10;
  std::vector<float> correction_wave{};
  /// The table itself, all around the circle and an entry further: what is added at the turn
  /// i / segments, and how much more at the next. Empty where there is a wave or no correction.
  std::vector<float> correction{};
  std::vector<float> correction_rise{};
  float segments = 0;
};

/// What else depends on the camera's bits and on what is asked for.
struct SinusoidLimits {
  float least_square = 0;  ///< of U^2 + sine_square V^2: the modulation threshold
  float mean_scale = 1;    ///< from the sum of the frames to the mean
  std::int32_t full_scale = std::numeric_limits<std::int32_t>::max();  ///< saturated from here on
};

/// Where a row of a sinusoid goes. `modulation` may be null.
struct SinusoidRow {
  int width = 0;
  float* turn = nullptr;  ///< wrapped phase / (2 pi), [0, 1], 1 being 0; a correction may lead out
  float* mean = nullptr;
  float* modulation = nullptr;    ///< grey levels
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  bool another = false;  ///< the second sinusoid: flags are added, the least modulation kept, the
                         ///< mean left alone
  /// Turns of dark pixels, and what else a second sinusoid says of them, may be left as they were.
  bool only_lit = false;
  bool nan_if_flagged = false;  ///< turns of dark and saturated pixels are NaN; not with `another`
};

void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint8_t* const* frames, const SinusoidRow& row);
void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint16_t* const* frames, const SinusoidRow& row);

/// From turns to projector coordinates in the field, see coordinate_in_field.
struct CoordinateStage {
  float scale = 1;   ///< 1 / f
  float period = 1;  ///< in which the coordinate is known
  float cut = 0;     ///< where the circle is cut
};

/// Fringe orders by a lower frequency, Eq. (1.17).
struct UnwrapStage {
  float ratio = 16;  ///< f_h / f_l
  float largest_doubt = 0.25F;
  CoordinateStage coordinate;  ///< of f_h
};

/// One frequency. In the fused pass point_row does it.
void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate);

struct UnwrappedRow {
  float* coordinate = nullptr;
  std::int32_t* flags = nullptr;
  float* doubt = nullptr;  ///< see DecodedScan; may be null
};

/// Two frequencies. Adds `doubtful_order` to the flags; the coordinate of a pixel with one of the
/// flags `hidden` is NaN, so that it confirms no neighbour.
void unwrap_row(const UnwrapStage& stage, int width, const float* high_turn, const float* low_turn,
                std::int32_t hidden, const UnwrappedRow& row);

/// Wrapped phase in [0, 2 pi) from turns.
void phase_row(int width, const float* turn, float* phase);

}  // namespace slipstream
