#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

// The stages of the fused pass, in float. A function works on one row of pixels; it is compiled
// once for each vector target, and the target is chosen at run time. Nothing is checked: rows must
// be at least `least_row_width` wide.
namespace slipstream {

/// Lanes of the widest vectors; a row's last vector overlaps the one before it.
inline constexpr int least_row_width = 16;

/// What is known of a pixel between the stages; a pixel with none of them is measured.
enum PixelFlag : std::int32_t {
  dark = 1,            ///< a modulation below the threshold
  saturated = 2,       ///< a frame at full scale, where such pixels are dropped
  doubtful_order = 4,  ///< bands, or band and cue, disagree by more than the consensus lets pass
  dim = 8,  ///< a modulation within the noise: the pixel has no say in its neighbours' orders
};

/// A row of each frame, of 8 or 16 bits a pixel.
struct FrameRows {
  // NOLINTNEXTLINE(google-explicit-constructor)
  FrameRows(const std::uint8_t* const* rows) : of_8_bits(rows) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  FrameRows(const std::uint16_t* const* rows) : of_16_bits(rows) {}

  const std::uint8_t* const* of_8_bits = nullptr;
  const std::uint16_t* const* of_16_bits = nullptr;
};

/// The corrected phase of 3, 4 or 6 frames straight from U and V, so that a correction takes the
/// place of the arctangent's polynomial instead of following it.
///
/// A response's harmonics are the same in each of the N periods and on both sides of a crest.
/// Reflections therefore fold the circle to the phases from 0 to T, T = pi/3 for N = 3 and 6 and
/// pi/4 for N = 4, where V/U (folded) goes from 0 to 1. There the corrected phase is a
/// polynomial in x = (U - (2 + b) V) / (U + b V), which goes from 1 to -1. Any b > -1 will do; it
/// is chosen so that the fewest terms are needed: where the correction bends most, near one end, x
/// runs fastest. For gamma 2.2 and N = 3 this takes degree 11 where powers of the angle or its
/// tangent take 20 and more.
struct FoldedPhase {
  static constexpr int largest_degree = 24;

  float b = 0;
  std::vector<float> coefficients{};  ///< of the phase in turns, from that of the highest power on

  [[nodiscard]] bool empty() const { return coefficients.empty(); }
};

/// How the N frames of one sinusoid become a phase. U = sum u_n I_n and V = sum v_n I_n stand for
/// the cosine and sine sums of Liu 2010, Eqs. (1.5), (1.6). For N = 3, 4, 6 they are the integers
/// of Eqs. (2.1)-(2.3), for N = 5 numbers a + b sqrt(5) with integers a and b; otherwise they are
/// sums with the weights `cosines` and `sines`.
struct SinusoidStage {
  int steps = 3;
  std::vector<double> cosines{};  ///< 2/N cos(2 pi n / N) for N above 6, or any other weights
  std::vector<double> sines{};
  /// N times what each of these frames counts for in the mean; empty where all count alike.
  std::vector<float> means{};
  /// All three of each frame, where cosines and sines are whole numbers whose sums over frames of
  /// 16 bits are exact in float; else empty.
  struct WholeWeights {
    float cosine = 0, sine = 0, mean = 1;
  };
  std::vector<WholeWeights> whole{};
  float sine_weight = 1;       ///< tan of the wrapped phase is this times V / U
  float sine_square = 1;       ///< its square
  float modulation_scale = 1;  ///< from the root of U^2 + sine_square V^2 to grey levels
  FoldedPhase folded{};        ///< the corrected phase; empty without correction or such a form
  /// What a PhaseCorrection adds, in turns, where it is an odd polynomial of r, the distance of N
  /// times the phase from the nearest whole turn: the coefficients of r^19, r^17, ..., r.
  /// Corrections of small gammas are of this form. Empty without correction, or where the table
  /// below holds it.
  static constexpr std::size_t wave_terms = 10;
  std::vector<float> correction_wave{};
  /// The same as a table around the circle, with one entry more: what is added at the turn
  /// i / segments, and in `correction_rise` how much more at the next entry. Empty without
  /// correction, or where the polynomial above holds it.
  std::vector<float> correction{};
  std::vector<float> correction_rise{};
  float segments = 0;
  /// From the turn so found to that of the band: direction 1 or -1, then offset; as found where
  /// neither is set.
  float direction = 1;
  float offset = 0;
};

/// What depends on the camera's bits and on the settings.
struct SinusoidLimits {
  float least_square = 0;  ///< of U^2 + sine_square V^2: the modulation threshold
  float mean_scale = 1;    ///< from the sum of the frames, or by `means`, to the mean
  std::int32_t full_scale = std::numeric_limits<std::int32_t>::max();  ///< saturated from here on
};

/// Where a row of a sinusoid goes. `modulation` may be null.
struct SinusoidRow {
  int width = 0;
  /// Wrapped phase / (2 pi), in [0, 1], where 1 is the same as 0; a correction may lead past the
  /// ends.
  float* turn = nullptr;
  float* mean = nullptr;
  float* modulation = nullptr;    ///< grey levels
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  /// The row holds a sinusoid of the same pixels already: flags are added to those there, the
  /// smaller modulation is kept, and the mean is left as it is.
  bool another = false;
  /// At dark pixels the turns, and with `another` all the rest, may be left as they were.
  bool only_lit = false;
  bool nan_if_flagged = false;  ///< turns of dark and saturated pixels are NaN; not with `another`
};

void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits, const FrameRows& frames,
                const SinusoidRow& row);

/// From turns to projector coordinates in the field, see coordinate_in_field.
struct CoordinateStage {
  float scale = 1;   ///< 1 / f
  float period = 1;  ///< the coordinate is known up to multiples of it
  float cut = 0;     ///< coordinates are brought into [cut, cut + period)
};

/// Fringe orders by a lower frequency, Eq. (1.17).
struct UnwrapStage {
  float ratio = 16;  ///< f_h / f_l
  float largest_doubt = 0.25F;
  float open = 0;              ///< of the doubt: so much means none
  float doubt_scale = 1;       ///< of what is left of it
  CoordinateStage coordinate;  ///< of f_h
};

/// Coordinates of a single frequency. In the fused pass point_row computes them itself.
void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate);

struct UnwrappedRow {
  float* coordinate = nullptr;
  std::int32_t* flags = nullptr;
  float* doubt = nullptr;    ///< see BasicMaps; may be null
  bool keeps_doubt = false;  ///< `doubt` holds that of an earlier step; the greater one stays
};

/// Coordinates of two frequencies. Adds `doubtful_order` to the flags; the coordinate of a pixel
/// with one of the flags `hidden` is NaN, so that it confirms no neighbour.
void unwrap_row(const UnwrapStage& stage, int width, const float* high_turn, const float* low_turn,
                std::int32_t hidden, const UnwrappedRow& row);

/// The coordinates next to `near` at which a band of so many periods has those turns.
void place_near(float periods, int width, const float* turn, const float* near, float* coordinate);

/// Wrapped phase in [0, 2 pi) from turns.
void phase_row(int width, const float* turn, float* phase);

/// How the bits of a Code become a coordinate.
struct CodeStage {
  std::vector<int> frames{};    ///< of the bits, most significant first; 1 or more
  std::vector<int> inverses{};  ///< to compare each with; empty: with the row's reference
  bool gray = true;
  std::int32_t base = 0;    ///< the bit that the others are shown in exclusive-or with; 0: none
  std::int32_t others = 0;  ///< those
  float stripe = 1;         ///< its width, fields
};

/// The coordinate of the middle of each pixel's stripe. `reference`: what is darker than a bright
/// bit, for each pixel, grey levels; null where there are inverses.
void code_row(const CodeStage& stage, int width, const FrameRows& frames, const float* reference,
              float* coordinate);

/// How the cue of PCMP becomes a coordinate, Liu 2010, Section 3.2: for N = 3 and 4 a reference in
/// the mean and in the half phase channel, R = 2 y - 1 (3.53) and R = cos(pi y) (3.68), for N >= 5
/// one period in the second full phase channel (3.83).
struct CueStage {
  std::vector<double> cosines{};  ///< of the second channel, (3.86), (3.85); for N above 6
  std::vector<double> sines{};
  float sine_weight = 1;  ///< of the second channel's sine sum against its cosine sum
  /// R = gain (channel - ambient) / B_1 - offset, (3.58), (3.74).
  float gain = 1;
  float offset = 0;
  float shade = 0;     ///< c_2 / c_1: what R adds to the mean, over B_1
  float periods = 12;  ///< f_h
  float largest_doubt = 0.25F;
  CoordinateStage coordinate;  ///< of f_h, known within one field
};

/// What depends on the camera's bits, beside SinusoidLimits.
struct CueLimits {
  float ambient = 0;        ///< beta, grey levels of the frames
  float lit_square = 0;     ///< of U^2 + sine_square V^2: up to it a pixel is `dim`
  float voting_square = 0;  ///< likewise: below it a pixel has no say in its neighbours' orders
};

/// Where a row of such frames goes. `modulation` may be null, and the last three are where only
/// points are wanted.
struct CueRow {
  int width = 0;
  /// As each pixel alone says it; NaN where it has no say in its neighbours' orders.
  float* coordinate = nullptr;
  float* mean = nullptr;
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  float* modulation = nullptr;
  float* turn = nullptr;
  float* doubt = nullptr;
  float* unhidden_coordinate = nullptr;  ///< as `coordinate`, but a number at every pixel
};

/// Frames of a row to coordinates, by the high frequency and its cue at once.
void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const FrameRows& frames, const CueRow& row);

}  // namespace slipstream
