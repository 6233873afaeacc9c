#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace slipstream {

/// Stripes, bright or dark in each frame, numbered by a Gray or plain binary code.
struct Code {
  double stripes = 2;         ///< across the field, 2 to 2^bits
  std::vector<int> frames{};  ///< one per bit, most significant first
  /// Optional: one frame per bit that shows it inverted.
  std::vector<int> inverses{};
  /// Threshold between bright and dark without `inverses`, as a weight per frame of the scan. If
  /// empty, half way between the darkest and the brightest bit.
  std::vector<double> reference{};
  bool gray = true;  ///< neighbouring stripes differ in one bit
  /// The bit whose pattern is XORed into the frames of all the others.
  std::optional<int> base{};

  friend bool operator==(const Code&, const Code&) = default;
};

inline constexpr int most_code_bits = 20;

/// Throws Error, beginning with `name`, unless there are 1 to most_code_bits bits, enough for the
/// stripes, with an inverse per bit or a weight per frame, all in frames of the scan.
void require_valid(const Code& code, int frames, std::string_view name);

/// Whether the frame for `bit` is bright at y in [0, 1].
bool is_bright(const Code& code, int bit, double y);

/// Intensity of frame n of the code at y: 0 or 1. The two frames after the bits are white and
/// black.
double code_intensity(const Code& code, int n, double y);

/// The code decoded at one pixel.
struct CodeReading {
  /// The first and the last stripe that doubtful bits allow, as at an edge, where one bit is
  /// doubtful; the same if none is. From 0 at y = 0, past the field if no stripe has that code
  /// word.
  int first = 0, last = 0;
  double spread = 0;    ///< stripes from the first possible one to the last; all with many doubtful
  double contrast = 0;  ///< half the range of the frames, like a modulation; of a code alone
};

/// `intensities`: one pixel in all frames of the scan. `noise`: their standard deviation; bits
/// nearer to the threshold than three of it are doubtful.
CodeReading read_code(const Code& code, std::span<const double> intensities, double noise = 0);

/// Bits in the order of their frames, the first the most significant.
struct CodeBits {
  unsigned shown = 0;     ///< 1 where the frame is bright
  unsigned doubtful = 0;  ///< 1 where it is nearer to the threshold than `tolerance`
};

/// The bits of one pixel; `intensities` and `tolerance` in the same unit.
CodeBits code_bits(const Code& code, std::span<const double> intensities, double tolerance);

/// The stripe from the bits shown in the frames, most significant first.
int stripe_of(const Code& code, unsigned shown);

/// The first pixel of a stripe if the projector has `pixels` across the field and its pixel x
/// shows y = x / pixels. Stripes need not be whole pixels wide: a stripe then has a pixel more or
/// less than its neighbours. Of stripes past the field: at most 2 `pixels`.
int first_pixel(const Code& code, int stripe, int pixels);

/// Phase of the first pattern and direction of the shifts. Pattern n has phase 2 pi f y + origin -
/// 2 pi n / N, or + 2 pi n / N if backwards.
struct Shifts {
  double origin = 0;  ///< rad, at the edge of the field, y = 0
  bool backwards = false;

  friend bool operator==(const Shifts&, const Shifts&) = default;
};

/// Phase that Eqs. (1.5), (1.6), which assume default shifts, measure for `phi`; rad, unwrapped.
double shifted_phase(const Shifts& shifts, double phi);
/// Inverse of shifted_phase; rad, [0, 2 pi).
double unshifted_phase(const Shifts& shifts, double shifted);

/// Consecutive frames that are N-step patterns.
struct StepRun {
  int first = 0;
  int steps = 0;
  Shifts shifts{};

  friend bool operator==(const StepRun&, const StepRun&) = default;
};

/// A sinusoid in the frames of a scan: C + i S = B exp(i phi), C = sum cosine[n] I_n, S = sum
/// sine[n] I_n, with mean A = sum mean[n] I_n. N-step patterns give Liu 2010, Eqs. (1.3), (1.5),
/// (1.6); any weights are valid for which the frames give C = B cos(phi), S = B sin(phi).
struct Band {
  double periods = 1;            ///< across the projector's field, > 0
  double share = 1;              ///< of the modulation: B over alpha alpha_p / 2, (0, 1]
  std::vector<double> cosine{};  ///< a weight per frame of the scan, also in `sine` and `mean`
  std::vector<double> sine{};
  std::vector<double> mean{};
  /// Periods of a carrier across the axis; 0 without one. With a carrier frames show cos(pi periods
  /// y) cos(2 pi carrier x), a sum of two oblique sinusoids, or each of these alone. C + i S is the
  /// first, of phase pi periods y + 2 pi carrier x; the second, of pi periods y - 2 pi carrier x,
  /// is `mirrored`. The band's phase is their sum, without the carrier; its B is the smaller one.
  double carrier = 0;
  std::vector<Band> mirrored{};  ///< one band if there is a carrier, otherwise empty
  /// In a window of motion, which is longer than one cycle of the steps: the cycle it starts with.
  std::optional<StepRun> cycle{};

  friend bool operator==(const Band&, const Band&) = default;
};

/// The reference R(y) of a cue, in [-1, 1], monotonic over y in [0, 1].
class CueReference {
 public:
  enum class Form {
    linear,  ///< 2 y - 1: Eq. (3.53)
    cosine,  ///< cos(pi y): Eq. (3.68)
    other,
  };

  explicit CueReference(Form form = Form::linear) : form_(form) {}
  /// A custom function. Throws Error unless it is monotonic and within [-1, 1].
  explicit CueReference(std::function<double(double y)> function);

  [[nodiscard]] Form form() const { return form_; }
  /// R(y), with y clamped to [0, 1].
  [[nodiscard]] double operator()(double y) const;
  /// The y in [0, 1] at which R is nearest to that value.
  [[nodiscard]] double inverse(double value) const;

  /// Custom functions are compared at sample points of the field.
  friend bool operator==(const CueReference& a, const CueReference& b);

 private:
  Form form_;
  std::function<double(double y)> function_;
};

/// A value per pixel that is monotonic in y, in the same frames as a band: sum weights[n] I_n =
/// dc (alpha (alpha_p / 2 + beta_p + beta) + beta) + alpha alpha_p share R(y) / 2, dc =
/// sum weights[n], Eqs. (3.56), (3.73).
struct Cue {
  double share = 0.5;             ///< of the modulation: c_2, (0, 1)
  std::vector<double> weights{};  ///< one per frame of the scan
  CueReference reference{};

  /// Weight of constant light: 1 in the DC channel, whose cue requires the ambient light; 0 in the
  /// half phase channel.
  [[nodiscard]] double dc() const;

  friend bool operator==(const Cue&, const Cue&) = default;
};

/// A single frame of a sinusoid with the first band's mean and modulation: mean + B cos(2 pi
/// periods y + origin).
struct SingleFrame {
  int frame = 0;
  double periods = 1;
  double origin = 0;  ///< rad

  friend bool operator==(const SingleFrame&, const SingleFrame&) = default;
};

struct UnwrappingWay;

/// How phases become a projector coordinate: one of these constants or a custom method. It points
/// to an UnwrappingWay, see unwrapping.h, which defines its properties.
class Unwrapping {
 public:
  static const Unwrapping none;          ///< one band; a coordinate only with at most one period
  static const Unwrapping hierarchical;  ///< each band by the next coarser one: Eq. (1.17)
  /// One order per connected surface: the one that fits the single frames best.
  static const Unwrapping surfaces;
  /// By the cue, or a second band in the same frames, and the neighbours: Section 3.2.
  static const Unwrapping vote;
  /// Hierarchical, by integer combinations of the bands' phases (heterodyne).
  static const Unwrapping beats;
  static const Unwrapping likelihood;  ///< maximum likelihood over all bands
  static const Unwrapping code;        ///< the code gives the measuring band's period: Eq. (1.18)
  static const Unwrapping code_alone;  ///< the centre of the code's stripe
  /// Maximum likelihood over the first band and all single frames.
  static const Unwrapping single_frames;

  /// `way` must outlive every use of this object.
  constexpr Unwrapping(const UnwrappingWay& way) : way_(&way) {}  // NOLINT

  const UnwrappingWay& operator*() const { return *way_; }
  const UnwrappingWay* operator->() const { return way_; }

  friend bool operator==(const Unwrapping&, const Unwrapping&) = default;

 private:
  const UnwrappingWay* way_;
};

/// How to read the frames of a scan: all that other code needs to know about a strategy.
struct Layout {
  int frames = 0;
  /// At least one, in any order; with Unwrapping::vote the first measures, and an optional second
  /// one, of one period, is its cue.
  std::vector<Band> bands{};
  std::optional<Cue> cue{};                  ///< with Unwrapping::vote and a single band
  std::optional<Code> code{};                ///< with Unwrapping::code and code_alone
  std::vector<SingleFrame> single_frames{};  ///< with Unwrapping::single_frames, after a run of
                                             ///< steps; with surfaces of at most one period
  Unwrapping unwrapping = Unwrapping::none;

  friend bool operator==(const Layout&, const Layout&) = default;
};

/// Throws Error, beginning with `name`, unless bands have finite weights for each frame that ignore
/// constant light in C and S and sum to 1 in the mean; periods and shares are in range; and the
/// layout suits the unwrapping: hierarchical requires a band of at most one period, beats and
/// likelihood bands whose combination is unique over the field, vote a cue or a second band, code a
/// code whose stripes are no wider than a period.
void require_valid(const Layout& layout, std::string_view name);

/// Throws Error, beginning with `name`, unless there is one weight per frame, they sum to 0 or 1,
/// and 0 < share < 1.
void require_valid(const Cue& cue, int frames, std::string_view name);

/// The band of N phase-shifted sinusoids in frames from `first` on: 2/N cos(2 pi m n / N), 2/N
/// sin(2 pi m n / N) and 1/N, phase channel m = 1: Eqs. (1.5), (1.6), or 2: (3.85), (3.86).
Band phase_shifted_band(int frames, int first, int steps, double periods, int channel = 1,
                        double share = 1, const Shifts& shifts = {});

/// Weights of the DC channel, (1.3), and of the half phase channel of 4 frames, (3.70).
inline std::vector<double> mean_weights(int steps) {
  return std::vector<double>(steps, 1.0 / steps);
}
inline std::vector<double> half_phase_weights() {
  return {0.25, -0.25, 0.25, -0.25};
}

/// The run of steps whose first phase channel is this band (or its first sinusoid, with a carrier);
/// nullopt for other weights. Its response can be corrected; N = 3, 4 and 6 have tables.
std::optional<StepRun> step_run(const Band& band);

/// Steps, in the frames or the cycle they come from, whose phase a nonlinear response distorts.
inline std::optional<StepRun> bent_run(const Band& band) {
  return band.cycle ? band.cycle : step_run(band);
}

/// Whether the band is that phase channel of the run.
bool is_channel(const Band& band, const StepRun& run, int channel);

/// Mean variance of C and S over the variance of a frame: 2 / N for N steps, Eq. (3.36); with a
/// carrier the sum over both sinusoids.
double component_noise(const Band& band);

/// N of each band that has a bent_run, in band order.
std::vector<int> step_counts(const Layout& layout);

/// Indices of the bands, from fewest periods to most.
std::vector<std::size_t> coarse_to_fine(const Layout& layout);

/// The band whose phase gives the coordinate.
std::size_t measuring_band_index(const Layout& layout);
inline const Band& measuring_band(const Layout& layout) {
  return layout.bands[measuring_band_index(layout)];
}

/// Frames whose grey levels matter: all except those of a code, which is only thresholded.
std::vector<int> measuring_frames(const Layout& layout);

/// Whether the frames alone determine the projector coordinate, and so the depth.
bool has_coordinate(const Layout& layout);

/// Whether decoding requires the ambient light: a cue in the DC channel.
bool needs_ambient_light(const Layout& layout);

/// The runs of phase steps of the bands, each once, in the order of the bands.
std::vector<StepRun> step_runs(const Layout& layout);

/// Most periods of a carrier; 0 if no pattern varies across the axis.
double carrier_periods(const Layout& layout);

/// Most periods across the field.
inline double highest_frequency(const Layout& layout) {
  return measuring_band(layout).periods;
}

}  // namespace slipstream
