#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "decode/neighbourhood_vote.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/fused/stage_numbers.h"
#include "slipstream/cloud.h"

// Stages of the fused pass, in float. Each function processes one row of pixels and is compiled for
// each vector target. Arguments are not checked: rows must be at least `least_row_width` wide.
namespace slipstream {

/// Lanes of the widest vectors; the last vector of a row overlaps the one before it.
inline constexpr int least_row_width = 16;

/// State of a pixel between the stages; a pixel without flags is measured.
enum PixelFlag : std::int32_t {
  dark = 1,            ///< modulation below the threshold
  saturated = 2,       ///< a frame at full scale, if such pixels are dropped
  doubtful_order = 4,  ///< bands, or band and cue, disagree by more than the consensus allows
  dim = 8,  ///< modulation within the noise: the pixel does not vote on its neighbours' orders
};

/// A row of each frame, 8 or 16 bits per pixel.
using FrameRows = std::variant<const std::uint8_t* const*, const std::uint16_t* const*>;

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

/// Coordinates of a single frequency. In the fused pass point_row computes them itself.
void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate);

/// Coordinates of pixels with any of the flags `hidden` are NaN, so that they confirm no neighbour.
struct UnwrappedRow {
  int width = 0;
  float* coordinate = nullptr;
  std::int32_t* flags = nullptr;
  std::int32_t hidden = 0;
  float* doubt = nullptr;    ///< see BasicMaps; may be null
  bool keeps_doubt = false;  ///< keeps the larger of this doubt and an earlier step's
};

/// Coordinates from two frequencies. Adds `doubtful_order` to the flags.
void unwrap_row(const UnwrapStage& stage, const float* high_turn, const float* low_turn,
                const UnwrappedRow& row);

/// Tries every fringe order of the measuring band.
struct OrderStage {
  /// A band or frame: cos(2 pi (ratio p - shift)), p the periods of the measuring band.
  struct Wave {
    float ratio = 1;
    float shift = 0;   ///< of a frame, turns
    int frame = 0;     ///< in the scan
    float weight = 0;  ///< of a band: inverse variance of its phase for B = 1
  };
  static constexpr int most_waves = 66;  ///< 3 steps and 63 single frames, as of micro

  float period = 1;          ///< of the band, fields
  float begin = 0, end = 1;  ///< of the field, periods of the band
  int orders = 1;            ///< to try, from -1 on
  float largest_doubt = 0.25F;
  std::vector<Wave> waves{};
  std::size_t steps = 0;  ///< frames of the measuring band, which are first; 0 of bands
  /// Of frames: cosine and sine of each at the beginning of each order, order after order.
  std::vector<std::array<float, 2>> beginnings{};
};

/// Coordinates from a row of each band, the measuring one first: see Unwrapping::likelihood.
void likelihood_row(const OrderStage& stage, const Image<float>& turns,
                    const Image<float>& modulations, const UnwrappedRow& row);

/// Coordinates from all frames: see Unwrapping::single_frames. Also flags saturated pixels.
void fit_row(const OrderStage& stage, const SinusoidLimits& limits, const FrameRows& frames,
             const float* turn, const UnwrappedRow& row);

/// Coordinates nearest to `near` at which a band of this many periods has these turns.
void place_near(float periods, int width, const float* turn, const float* near, float* coordinate);

/// Wrapped phase in [0, 2 pi), from turns.
void phase_row(int width, const float* turn, float* phase);

/// From the bits of a Code to a coordinate.
struct CodeStage : CodeNumbers {
  std::vector<int> frames{};    ///< one per bit, most significant first; at least one
  std::vector<int> inverses{};  ///< their inverses; empty: compare with the row's reference
  bool alone = false;           ///< Unwrapping::code_alone; else no member below counts
  std::vector<int> rest{};      ///< frames that are no bits
  float narrower = 0;           ///< CodeNumbers::stripe less its exact width: rounds y once
  float shift = 0;              ///< from y = 0 to the edge of the first stripe, fields
  float largest_doubt = 0.25F;
  float tolerance = 0;       ///< bits nearer to the threshold are doubtful, grey levels of 255
  float least_contrast = 0;  ///< pixels of less are dark, grey levels of 255
};

/// Coordinate of the middle of each pixel's stripe; of a code alone, of all stripes that its
/// doubtful bits allow. `reference`: grey level above which a bit is bright, for each pixel; null
/// if there are inverse frames, or if it is half way between the darkest and the brightest bit.
/// `contrast`: of a code alone, see CodeReading; may be null. `grey_level`: one of 255.
void code_row(const CodeStage& stage, float grey_level, const FrameRows& frames,
              const float* reference, float* contrast, const UnwrappedRow& row);

/// From a cue to a coordinate, Liu 2010, Section 3.2: R = 2 y - 1 in the mean for N = 3 (3.53), R =
/// cos(pi y) in the half phase channel for N = 4 (3.68), one period in the second full phase
/// channel for N >= 5 (3.83); the linear cue of other strategies, and all of these in windows
/// longer than a cycle.
struct CueStage : CueNumbers {
  enum class Sums {
    closed,    ///< those of N = 3 to 6, in integers
    mirrored,  ///< by the weights below, the same of frames n and N - n up to a sign
    any,       ///< by any weights
  };

  CueForm form = CueForm::circle;
  Sums sums = Sums::closed;
  /// Weights of the cue's channel, (3.86), (3.85), unless its sums are closed.
  std::vector<double> cosines{}, sines{};
  float channel_scale = 1;       ///< grey levels per unit of the channel's sum
  float sine_weight = 1;         ///< of the second channel's sine sum relative to its cosine sum
  CoordinateStage coordinate{};  ///< of f_h, within one field
};

/// One row of results from frames with a cue. `modulation` may be null; so may the last three if
/// only points are wanted.
struct CueRow {
  SinusoidLimits limits{};
  CueLimits cue_limits{};
  int width = 0;
  /// From each pixel alone; NaN if it does not vote on its neighbours' orders.
  float* coordinate = nullptr;
  float* mean = nullptr;
  std::int32_t* flags = nullptr;  ///< PixelFlag
  bool past_cache = false;        ///< `mean` is aligned to 8 floats and written past the cache
  float* modulation = nullptr;
  float *turn = nullptr, *doubt = nullptr;
  float* unhidden_coordinate = nullptr;  ///< the same, but never NaN
};

/// Frames of a row to coordinates, from the high frequency and its cue together.
void decode_row(const SinusoidStage& stage, const CueStage& cue, const FrameRows& frames,
                const CueRow& row);

/// A row of coordinates and its neighbours. Each has one NaN before it, and after it enough to
/// complete a vector plus one.
struct CoordinateRows {
  int width = 0, row = 0;
  const float *above = nullptr, *here = nullptr, *below = nullptr;
  /// One per vector: whether a step from the row above may disagree; on return, to the row below.
  std::uint8_t* far_above = nullptr;
};

/// Appends, from left to right, the pixels of NeighbourhoodVote::disagrees, and a few more.
void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found);

/// Cost of fringe orders from frames with a cue: CueEvidence::cost.
struct OrderCostStage : OrderCostNumbers {
  /// Weight of each frame in C, in S, and in the cue's channel or its cosine and sine.
  std::vector<double> cosines{}, sines{}, cue{}, cue_sine{};
};

/// Shifts of a pixel's fringe order whose costs votes need often.
inline constexpr std::array order_shifts{-2, -1, 1, 2};
constexpr std::size_t index_of_shift(int shift) {
  return static_cast<std::size_t>(shift < 0 ? shift + 2 : shift + 1);
}

/// Costs of the shifted orders, minus the cost of the pixel's own; infinite outside the field.
using OrderCosts = std::array<float*, order_shifts.size()>;

inline constexpr int costed_together = 16;

/// Costs of `costed_together` pixels. `to_8_bits`: 8-bit levels per grey level of the frames;
/// `coordinate`: from the pixels' own orders; costs are undefined where it is NaN.
void order_costs(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                 const float* coordinate, const OrderCosts& costs);

/// Input of NeighbourhoodVote, in images of one width that keep the last rows, a power of two of
/// them, with 16 more columns on both sides. Each pointer is to the pixel at row 0, column 0.
struct BallotRows {
  const float* coordinate = nullptr;                      ///< NaN if invalid or outside the image
  const std::int16_t* shift = nullptr;                    ///< null if all are 0
  std::array<const float*, order_shifts.size()> costs{};  ///< OrderCosts of the voters
  std::ptrdiff_t stride = 0;
  int kept_rows = 1;
  float periods = 12;  ///< f_h
};

/// NeighbourhoodVote::chosen_shift of each pixel. It stays `undecided` if orders beyond those of
/// order_shifts would matter, or rounding or a line of pixels could decide. With `restores`: 0 if
/// NeighbourhoodVote::has_support, else 1.
void hold_ballots(const BallotRows& rows, std::span<ShiftedPixel> pixels, bool restores);

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
