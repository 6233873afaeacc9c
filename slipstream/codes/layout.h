#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace slipstream {

/// Stripes, bright or dark in some frames, numbered by a Gray code or a plain binary one.
struct Code {
  double stripes = 2;         ///< across the field, 2 to 2^bits
  std::vector<int> frames{};  ///< of the bits, most significant first
  /// Where not empty, a frame for each bit that shows it with bright and dark exchanged.
  std::vector<int> inverses{};
  /// Else the threshold between bright and dark, as a weight for each frame of the scan. Empty too:
  /// half way between the darkest and the brightest bit.
  std::vector<double> reference{};
  bool gray = true;  ///< neighbouring stripes differ in one bit
  /// The bit that the frames of all others show in exclusive-or with themselves.
  std::optional<int> base{};

  friend bool operator==(const Code&, const Code&) = default;
};

inline constexpr int most_code_bits = 20;

/// Throws Error, beginning with `name`, unless there are 1 to most_code_bits bits, enough for the
/// stripes, an inverse for each or a weight for each frame, all in frames of the scan.
void require_valid(const Code& code, int frames, std::string_view name);

/// Whether the frame of that bit is bright at y in [0, 1].
bool is_bright(const Code& code, int bit, double y);

/// What frame n of the code shows at y: 0 or 1. The two after those of the bits are white and
/// black.
double code_intensity(const Code& code, int n, double y);

/// What the code says of one pixel.
struct CodeReading {
  int stripe = 0;  ///< counted from 0 at y = 0; past the last one where no stripe has that word
  /// How far the bits are from the threshold, grey levels: the second least, as at a stripe's edge
  /// one of them is rightly in between; of a single bit its own.
  double contrast = 0;
};

/// `intensities`: of all frames of the scan, one pixel's.
CodeReading read_code(const Code& code, std::span<const double> intensities);

/// The bits of a word, from those that frames show, most significant first.
int stripe_of(const Code& code, unsigned shown);

/// Phase of the first pattern and direction of the shifts: pattern n has 2 pi f y + origin - 2 pi n
/// / N, or + 2 pi n / N backwards.
struct Shifts {
  double origin = 0;  ///< rad, at the edge of the field, y = 0
  bool backwards = false;

  friend bool operator==(const Shifts&, const Shifts&) = default;
};

/// The phase as the N equations (1.5), (1.6) see it, which know of no such shifts; rad, any.
double shifted_phase(const Shifts& shifts, double phi);
/// The phase from what they see, rad, [0, 2 pi).
double unshifted_phase(const Shifts& shifts, double shifted);

/// Frames in a row that are N-step patterns.
struct StepRun {
  int first = 0;
  int steps = 0;
  Shifts shifts{};

  friend bool operator==(const StepRun&, const StepRun&) = default;
};

/// A sinusoid in the frames of a scan: C + i S = B exp(i phi), C = sum cosine[n] I_n, S = sum
/// sine[n] I_n, with mean A = sum mean[n] I_n. N-step patterns give Liu 2010, Eqs. (1.3), (1.5),
/// (1.6); any weights do for which the frames shown give C = B cos(phi), S = B sin(phi).
struct Band {
  double periods = 1;            ///< across the projector's field, > 0
  double share = 1;              ///< of the modulation: B over alpha alpha_p / 2, (0, 1]
  std::vector<double> cosine{};  ///< a weight for each frame of the scan, as `sine` and `mean`
  std::vector<double> sine{};
  std::vector<double> mean{};
  /// Periods of a carrier across the axis; 0: none. Frames then show cos(pi periods y) cos(2 pi
  /// carrier x), a sum of two oblique sinusoids, or each of these alone. C + i S is the one, of
  /// phase pi periods y + 2 pi carrier x; the other, of pi periods y - 2 pi carrier x, is
  /// `mirrored`. The band's phase is their sum, without the carrier; its B the lesser of theirs.
  double carrier = 0;
  std::vector<Band> mirrored{};  ///< one with a carrier, else none
  /// Of a window over several cycles of steps, see motion_window: those it begins with.
  std::optional<StepRun> cycle{};

  friend bool operator==(const Band&, const Band&) = default;
};

/// What a cue follows across the field: R(y) in [-1, 1], rising or falling throughout y in [0, 1].
class CueReference {
 public:
  enum class Form {
    linear,  ///< 2 y - 1: Eq. (3.53)
    cosine,  ///< cos(pi y): Eq. (3.68)
    other,
  };

  explicit CueReference(Form form = Form::linear) : form_(form) {}
  /// Another function. Throws Error unless it is monotonic and within [-1, 1].
  explicit CueReference(std::function<double(double y)> function);

  [[nodiscard]] Form form() const { return form_; }
  /// R(y), y held to [0, 1].
  [[nodiscard]] double operator()(double y) const;
  /// The y in [0, 1] at which R has that value, or the nearest it has.
  [[nodiscard]] double inverse(double value) const;

  /// Functions are compared at some places of the field.
  friend bool operator==(const CueReference& a, const CueReference& b);

 private:
  Form form_;
  std::function<double(double y)> function_;
};

/// A number for each pixel that is monotonic in y, in the same frames as a band: sum weights[n] I_n
/// = dc (alpha (alpha_p / 2 + beta_p + beta) + beta) + alpha alpha_p share R(y) / 2, dc = sum
/// weights[n], Eqs. (3.56), (3.73).
struct Cue {
  double share = 0.5;             ///< of the modulation: c_2, (0, 1)
  std::vector<double> weights{};  ///< one for each frame of the scan
  CueReference reference{};

  /// Weight of constant light: 1 in the DC channel, whose cue needs the ambient light; 0 in the
  /// half phase channel.
  [[nodiscard]] double dc() const;

  friend bool operator==(const Cue&, const Cue&) = default;
};

/// A frame of one sinusoid with the first band's mean and modulation: mean + B cos(2 pi periods y +
/// origin).
struct SingleFrame {
  int frame = 0;
  double periods = 1;
  double origin = 0;  ///< rad

  friend bool operator==(const SingleFrame&, const SingleFrame&) = default;
};

struct UnwrappingWay;

/// How phases become a projector coordinate: one of these, or a way of one's own. What it means for
/// the rest is said by its UnwrappingWay, see unwrapping.h, to which it points.
class Unwrapping {
 public:
  static const Unwrapping none;  ///< one band of at most one period; of more without a coordinate
  static const Unwrapping hierarchical;  ///< each band by the one of fewer periods: Eq. (1.17)
  /// Each connected surface by the order under which its single frames fit best.
  static const Unwrapping surfaces;
  /// By the cue, or a second band in the same frames, and the neighbours: Section 3.2.
  static const Unwrapping vote;
  /// Hierarchical, by whole sums and differences of the bands' phases (heterodyne).
  static const Unwrapping beats;
  static const Unwrapping likelihood;  ///< the coordinate that is likeliest by all bands together
  static const Unwrapping code;        ///< the code names the measuring band's period: Eq. (1.18)
  static const Unwrapping code_alone;  ///< the middle of the code's stripe
  /// The coordinate that is likeliest by the first band and all single frames.
  static const Unwrapping single_frames;

  /// The way must live as long as whatever is unwrapped by it.
  constexpr Unwrapping(const UnwrappingWay& way) : way_(&way) {}  // NOLINT

  const UnwrappingWay& operator*() const { return *way_; }
  const UnwrappingWay* operator->() const { return way_; }

  friend bool operator==(const Unwrapping&, const Unwrapping&) = default;

 private:
  const UnwrappingWay* way_;
};

/// What the frames of a scan hold: all that other code needs to know of a strategy.
struct Layout {
  int frames = 0;
  /// At least one, in any order; with Unwrapping::vote the first measures, and a second one, of one
  /// period, is its cue.
  std::vector<Band> bands{};
  std::optional<Cue> cue{};                  ///< with Unwrapping::vote, where there is one band
  std::optional<Code> code{};                ///< with Unwrapping::code and code_alone
  std::vector<SingleFrame> single_frames{};  ///< with Unwrapping::single_frames, a run of steps
                                             ///< first; with surfaces of at most one period
  Unwrapping unwrapping = Unwrapping::none;

  friend bool operator==(const Layout&, const Layout&) = default;
};

/// Throws Error, beginning with `name`, unless there are bands with finite weights for each frame,
/// which ignore constant light in C and S and sum to 1 in the mean; periods and shares are in
/// range; and the unwrapping has what it needs: hierarchical a band of at most one period, beats
/// and likelihood bands that repeat nowhere together in the field, vote a cue or a second band,
/// code one whose stripes are no wider than a period.
void require_valid(const Layout& layout, std::string_view name);

/// Throws Error, beginning with `name`, unless the weights, one a frame, sum to 0 or 1 and 0 <
/// share < 1.
void require_valid(const Cue& cue, int frames, std::string_view name);

/// The band of N phase-shifted sinusoids in frames from `first` on: 2/N cos(2 pi m n / N), 2/N
/// sin(2 pi m n / N) and 1/N, phase channel m = 1: Eqs. (1.5), (1.6), or 2: (3.85), (3.86).
Band phase_shifted_band(int frames, int first, int steps, double periods, int channel = 1,
                        double share = 1, const Shifts& shifts = {});

/// The weights of a channel alone, for N frames.
std::vector<double> channel_cosines(int steps, int channel);
std::vector<double> channel_sines(int steps, int channel);
/// Of the DC channel, (1.3), and of the half phase channel of 4 frames, (3.70).
inline std::vector<double> mean_weights(int steps) {
  return std::vector<double>(static_cast<std::size_t>(steps), 1.0 / steps);
}
inline std::vector<double> half_phase_weights() {
  return {0.25, -0.25, 0.25, -0.25};
}

/// The run of steps whose first phase channel the band is (with a carrier its first sinusoid);
/// nullopt for other weights. A response can be corrected for it; for N = 3, 4, 6 there are tables.
std::optional<StepRun> step_run(const Band& band);
/// The steps, in the frames or in the cycle they come from, by which a response bends the phase.
inline std::optional<StepRun> bent_run(const Band& band) {
  return band.cycle ? band.cycle : step_run(band);
}
/// Whether the band is that phase channel of the run.
bool is_channel(const Band& band, const StepRun& run, int channel);

/// Variance of C and S, on average, over that of a frame: 2 / N for N steps, Eq. (3.36); with a
/// carrier the sum of both sinusoids'.
double component_noise(const Band& band);

/// N of each band that has a bent_run, in the order of the bands.
std::vector<int> step_counts(const Layout& layout);

/// Indices of the bands, from few periods to many.
std::vector<std::size_t> coarse_to_fine(const Layout& layout);
/// The band whose phase gives the coordinate.
std::size_t measuring_band_index(const Layout& layout);
inline const Band& measuring_band(const Layout& layout) {
  return layout.bands[measuring_band_index(layout)];
}
/// The frames whose levels count, not only which of them is brighter: all but those of a code.
std::vector<int> measuring_frames(const Layout& layout);

/// Whether the frames alone give the projector coordinate, and so a depth.
bool has_coordinate(const Layout& layout);
/// Whether that takes the ambient light: a cue in the DC channel.
bool needs_ambient_light(const Layout& layout);
/// Most periods of a carrier; 0 where no pattern varies across the axis.
double carrier_periods(const Layout& layout);
/// Most periods across the field.
inline double highest_frequency(const Layout& layout) {
  return measuring_band(layout).periods;
}

/// A window of N + `extra` frames, from pattern `first` on, of a cycle of N steps shown over and
/// over. Each N frames in a row give the phasor B exp(i phi); motion between frames adds one that
/// turns the other way, a phase ripple at twice the fringe. A weighted sum of the extra + 1
/// successive phasors gives that ripple a multiple zero: with x the step from frame to frame, the
/// characteristic polynomial (Surrel 1996) is that of N steps times (x - x_0)^extra, x_0 its zero
/// at the conjugate fringe. For N = 4 the weights are binomial (Zhang et al., arXiv 2404.06693).
/// The phase is that of the window's middle, as if the fringe stood still. Means, cues and further
/// channels, as PCMP's, have zeros where the moving phase disturbs them. Throws Error unless all
/// that is read differs by equal shifts from frame to frame, 0 <= extra <= 16 and 0 <= first < N.
Layout motion_window(const Layout& cycle, int extra, int first = 0);

/// Amplitude of that ripple, rad, where the phase moves by `speed` rad from frame to frame.
double motion_ripple(const Layout& cycle, int extra, double speed);

}  // namespace slipstream
