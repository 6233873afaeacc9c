#pragma once

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/reconstruct/fused/stage_numbers.h"

// The stages of the fused pass, in float: each function works on one row of pixels and is compiled
// for each vector target. Nothing is checked: rows are at least `least_row_width` wide.
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
  FrameRows() = default;
  // NOLINTNEXTLINE(google-explicit-constructor)
  FrameRows(const std::uint8_t* const* rows) : of_8_bits(rows) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  FrameRows(const std::uint16_t* const* rows) : of_16_bits(rows) {}

  [[nodiscard]] FrameRows from(int frame) const {
    return of_8_bits != nullptr ? FrameRows(of_8_bits + frame) : FrameRows(of_16_bits + frame);
  }

  const std::uint8_t* const* of_8_bits = nullptr;
  const std::uint16_t* const* of_16_bits = nullptr;
};

/// The corrected phase of 3, 4 or 6 frames straight from U and V: the correction takes the place of
/// the arctangent's polynomial.
///
/// A response's harmonics are the same in each of the N periods and on both sides of a crest, so
/// reflections fold the circle to the phases from 0 to T, T = pi/3 for N = 3 and 6 and pi/4 for
/// N = 4, where V/U (folded) goes from 0 to 1. There the corrected phase is a polynomial in
/// x = (U - (2 + b) V) / (U + b V), which goes from 1 to -1. b > -1 is chosen so that the fewest
/// terms are needed: x runs fastest where the correction bends most. Gamma 2.2 and N = 3 take
/// degree 11; powers of the angle or its tangent 20 and more.
struct FoldedPhase {
  static constexpr int largest_degree = 24;

  float b = 0;
  std::vector<float> coefficients{};  ///< of the phase in turns, highest power first

  [[nodiscard]] bool empty() const { return coefficients.empty(); }
};

/// How the N frames of one sinusoid become a phase. U = sum u_n I_n and V = sum v_n I_n stand for
/// the cosine and sine sums of Liu 2010, Eqs. (1.5), (1.6). For N = 3, 4, 6 they are the integers
/// of Eqs. (2.1)-(2.3), for N = 5 numbers a + b sqrt(5) with integers a and b; otherwise they are
/// sums with the weights `cosines` and `sines`.
struct SinusoidStage : SinusoidNumbers {
  /// 2/N cos(2 pi n / N) and its sines for N above 6, or any other weights.
  std::vector<double> cosines{}, sines{};
  /// N times what each of these frames counts for in the mean; empty where all count alike.
  std::vector<float> means{};
  /// All three of each frame, where cosines and sines are whole numbers whose sums over frames of
  /// 16 bits are exact in float; else empty.
  struct WholeWeights {
    float cosine = 0, sine = 0, mean = 1;
  };
  std::vector<WholeWeights> whole{};
  FoldedPhase folded{};  ///< the corrected phase; empty without correction or such a form
  /// What a PhaseCorrection adds, in turns, where it is an odd polynomial of r, the distance of N
  /// times the phase from the nearest whole turn, as for small gammas: the coefficients of r^19,
  /// r^17, ..., r. Empty without correction, or where the table below holds it.
  static constexpr std::size_t wave_terms = 10;
  std::vector<float> correction_wave{};
  /// Else a table around the circle, with one entry more: what is added at the turn i / segments,
  /// and in `correction_rise` how much more at the next entry.
  std::vector<float> correction{}, correction_rise{};
  float segments = 0;
};

/// A row of a sinusoid and where it goes. `modulation` may be null.
struct SinusoidRow {
  SinusoidLimits limits{};
  int width = 0;
  /// Wrapped phase / (2 pi), in [0, 1], where 1 is 0; a correction may lead past the ends.
  float* turn = nullptr;
  float *mean = nullptr, *modulation = nullptr;  ///< grey levels
  std::int32_t* flags = nullptr;                 ///< PixelFlag
  bool past_cache = false;  ///< `mean` is aligned to 8 floats and written past the cache
  /// The row holds a sinusoid of the same pixels already: flags are added to those there, the
  /// smaller modulation is kept, and the mean is left as it is.
  bool another = false;
  /// At dark pixels the turns, and with `another` all the rest, may be left as they were.
  bool only_lit = false;
  bool nan_if_flagged = false;  ///< turns of dark and saturated pixels are NaN; not with `another`
};

void decode_row(const SinusoidStage& stage, const FrameRows& frames, const SinusoidRow& row);

/// Coordinates of a single frequency. In the fused pass point_row computes them itself.
void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate);

struct UnwrappedRow {
  float* coordinate = nullptr;
  std::int32_t* flags = nullptr;
  float* doubt = nullptr;    ///< see BasicMaps; may be null
  bool keeps_doubt = false;  ///< the greater of this and an earlier step's stays
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
struct CodeStage : CodeNumbers {
  std::vector<int> frames{};    ///< of the bits, most significant first; 1 or more
  std::vector<int> inverses{};  ///< to compare each with; empty: with the row's reference
};

/// The coordinate of the middle of each pixel's stripe. `reference`: what is darker than a bright
/// bit, for each pixel, grey levels; null where there are inverses.
void code_row(const CodeStage& stage, int width, const FrameRows& frames, const float* reference,
              float* coordinate);

/// How the cue of PCMP becomes a coordinate, Liu 2010, Section 3.2: R = 2 y - 1 in the mean of N =
/// 3 (3.53), R = cos(pi y) in the half phase channel of N = 4 (3.68), one period in the second full
/// phase channel of N >= 5 (3.83).
struct CueStage : CueNumbers {
  /// Of the second channel, (3.86), (3.85); for N above 6.
  std::vector<double> cosines{}, sines{};
  float sine_weight = 1;         ///< of the second channel's sine sum against its cosine sum
  CoordinateStage coordinate{};  ///< of f_h, known within one field
};

/// A row of such frames and where it goes. `modulation` may be null, and the last three are where
/// only points are wanted.
struct CueRow {
  SinusoidLimits limits{};
  CueLimits cue_limits{};
  int width = 0;
  /// As each pixel alone says it; NaN where it has no say in its neighbours' orders.
  float* coordinate = nullptr;
  float* mean = nullptr;
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  float* modulation = nullptr;
  float *turn = nullptr, *doubt = nullptr;
  float* unhidden_coordinate = nullptr;  ///< as `coordinate`, but a number at every pixel
};

/// Frames of a row to coordinates, by the high frequency and its cue at once.
void decode_row(const SinusoidStage& stage, const CueStage& cue, const FrameRows& frames,
                const CueRow& row);

/// A row of coordinates and its neighbours; all three have a NaN before, and after as many as
/// complete a vector and one more.
struct CoordinateRows {
  int width = 0, row = 0;
  const float *above = nullptr, *here = nullptr, *below = nullptr;
  /// Of each vector: whether a step from the row above may disagree; then that to the row below.
  std::uint8_t* far_above = nullptr;
};

/// Appends, from left to right, the pixels of a row for which NeighbourhoodVote::disagrees says so,
/// and a few more.
void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found);

/// How frames with a cue say what a fringe order costs: CueEvidence::cost.
struct OrderCostStage : OrderCostNumbers {
  /// What a frame counts for in C, S, and in the cue's channel or its cosine and sine.
  std::vector<double> cosines{}, sines{}, cue{}, cue_sine{};
};

/// What it costs the pixels of a row to be one period below or above their own fringe orders, less
/// what these cost; infinite past the field.
struct OrderCosts {
  float *below = nullptr, *above = nullptr;
};

inline constexpr int costed_together = 16;

/// Of `costed_together` pixels. `to_8_bits`: a grey level of the frames in those of 8 bits;
/// `coordinate`: by their own orders; where it is NaN the costs mean nothing.
void order_costs(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                 const float* coordinate, const OrderCosts& costs);

/// What NeighbourhoodVote looks at, in images of one width that keep the last rows, a power of two
/// of them, and have 16 columns more on both sides. Of each the pixel of row 0, column 0.
struct BallotRows {
  const float* coordinate = nullptr;  ///< NaN where it means nothing and outside the picture
  const std::int16_t* shift = nullptr;
  const float *below = nullptr, *above = nullptr;  ///< OrderCosts of those that vote
  std::ptrdiff_t stride = 0;
  int kept_rows = 1;
  float periods = 12;  ///< f_h
};

/// NeighbourhoodVote::chosen_shift of each pixel; it stays `undecided` where orders beyond the next
/// would have a say, or rounding or a line of pixels might decide. `restores`: instead 0 where
/// NeighbourhoodVote::has_support, else 1.
void hold_ballots(const BallotRows& rows, std::span<ShiftedPixel> pixels, bool restores);

struct PointStage : PointNumbers {
  std::vector<float> lens{};  ///< PlanePolynomial, last coefficient first
  bool limits_depth = false;  ///< `nearest` and `farthest` are not 0 and infinity
};

/// What a row of points is made of and where it goes.
struct PointRow {
  int width = 0;
  const float *E_x = nullptr, *E_y = nullptr;
  RayBlocks::Row blocks{};  ///< `described` null where there are none
  const std::int32_t* flags = nullptr;
  const float* coordinate = nullptr;
  /// Of coordinates, for the consensus; null without one. With it all three rows have a NaN before
  /// their first and after their last pixel.
  const float *above = nullptr, *below = nullptr;
  float *x = nullptr, *y = nullptr, *z = nullptr;  ///< mm; no x, y where only depth is wanted
  Validity* validity = nullptr;
  bool past_cache = false;  ///< x, y, z are aligned to 8 floats and written past the cache
};

/// For a single frequency: `row.coordinate` holds turns, NaN where a pixel is dark or saturated,
/// which `coordinate` makes projector coordinates. Ranges of blocks must end at the cut, see
/// FusedStages::blocks.
void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row);
/// For several frequencies or a cue: `row.coordinate` holds projector coordinates, which the
/// neighbours must confirm.
void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row);

/// DepthScale of a row.
void number_row(const DepthScale& scale, int width, const float* z, std::uint16_t* numbers);

/// x, y, z and intensity of pixels, or where those of points go.
template <class Real>
struct PointValues {
  Real *x = nullptr, *y = nullptr, *z = nullptr, *intensity = nullptr;
};

/// Writes the pixels of a row that have a depth one behind another, and returns how many. `room`:
/// so many values may be overwritten there. What is read may be there too, but not before it.
std::size_t pack_row(int width, const PointValues<const float>& from, const PointValues<float>& to,
                     std::size_t room);

/// After rows that were written past the cache, before another thread reads them.
void flush_past_cache();

}  // namespace slipstream
