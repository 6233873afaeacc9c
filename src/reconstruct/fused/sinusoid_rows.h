#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/stage_numbers.h"

namespace slipstream {

/// Corrected phase of 3, 4 or 6 frames directly from U and V: the correction replaces the
/// polynomial of the arctangent.
///
/// The harmonics of a response are the same in each of the N periods and on both sides of a crest,
/// so reflections fold the circle to phases from 0 to T, T = pi/3 for N = 3 and 6 and pi/4 for N =
/// 4, where the folded V/U goes from 0 to 1. There the corrected phase is a polynomial in x = (U -
/// (2 + b) V) / (U + b V), which goes from 1 to -1. b > -1 minimises the degree: x runs fastest
/// where the correction bends most. Gamma 2.2 with N = 3 needs degree 11; powers of the angle or
/// its tangent need 20 and more.
struct FoldedPhase {
  static constexpr int largest_degree = 24;

  float b = 0;
  std::vector<float> coefficients{};  ///< of the phase in turns, highest power first

  [[nodiscard]] bool empty() const { return coefficients.empty(); }
};

/// From the N frames of one sinusoid to its phase. U = sum u_n I_n and V = sum v_n I_n stand for
/// the cosine and sine sums of Liu 2010, Eqs. (1.5), (1.6). For N = 3, 4, 6 they are the integers
/// of Eqs. (2.1)-(2.3), for N = 5 numbers a + b sqrt(5) with integers a and b; otherwise they are
/// sums with the weights `cosines` and `sines`.
struct SinusoidStage : SinusoidNumbers {
  /// 2/N cos(2 pi n / N) and the sines for N above 6, or any other weights.
  std::vector<double> cosines{}, sines{};
  /// N times the weight of each frame in the mean; empty for equal weights.
  std::vector<float> means{};
  /// The three weights of each frame if cosines and sines are whole numbers whose sums over 16-bit
  /// frames are exact in float; else empty.
  struct WholeWeights {
    float cosine = 0, sine = 0, mean = 1;
  };
  std::vector<WholeWeights> whole{};
  FoldedPhase folded{};  ///< corrected phase; empty without a correction or if it has no such form
  /// A correction, in turns, as an odd polynomial of r, the distance of N times the phase from the
  /// nearest whole turn: coefficients of r^19, r^17, ..., r. Fits small gammas; empty without a
  /// correction or if the table below is used.
  static constexpr std::size_t wave_terms = 10;
  std::vector<float> correction_wave{};
  /// Otherwise a table around the circle with one extra entry: the correction at turn i / segments,
  /// and in `correction_rise` the difference to the next entry.
  std::vector<float> correction{}, correction_rise{};
  float segments = 0;
};

/// One row of a sinusoid's results. `modulation` may be null.
struct SinusoidRow {
  SinusoidLimits limits{};
  int width = 0;
  /// Wrapped phase / (2 pi), in [0, 1], where 1 means 0; a correction may exceed the ends.
  float* turn = nullptr;
  float *mean = nullptr, *modulation = nullptr;  ///< grey levels
  float* own_modulation = nullptr;               ///< of this sinusoid alone; may be null
  std::int32_t* flags = nullptr;                 ///< PixelFlag
  bool past_cache = false;  ///< `mean` is aligned to 8 floats and written past the cache
  /// The row has results of another sinusoid: adds flags, keeps mean and smaller modulation.
  bool another = false;
  /// Turns of dark pixels, and with `another` all their values, may be left unwritten.
  bool only_lit = false;
  bool nan_if_flagged = false;  ///< turns of dark and saturated pixels are NaN; not with `another`
};

void decode_row(const SinusoidStage& stage, const FrameRows& frames, const SinusoidRow& row);

}  // namespace slipstream
