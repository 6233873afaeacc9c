#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace slipstream {

/// Stripes that are bright or dark in some frames, which together number them: a Gray code or a
/// plain binary one.
struct Code {
  double stripes = 2;         ///< across the field, 2 to 2^bits
  std::vector<int> frames{};  ///< of the bits, most significant first
  /// Where not empty, a frame for each bit that shows it with bright and dark exchanged.
  std::vector<int> inverses{};
  /// Else what is darker than a bright bit and brighter than a dark one: a weight for each frame of
  /// the scan. Empty too: what lies half way between the brightest and the darkest of the bits.
  std::vector<double> reference{};
  bool gray = true;  ///< neighbouring stripes differ in one bit
  /// The bit that the frames of all others show in exclusive-or with themselves.
  std::optional<int> base{};

  friend bool operator==(const Code&, const Code&) = default;
};

inline constexpr int most_code_bits = 20;

/// Throws Error, beginning with `name`, unless there are 1 to most_code_bits bits, as many inverses
/// or a weight for each frame, frames of the scan and enough bits for the stripes.
void require_valid(const Code& code, int frames, std::string_view name);

/// Whether the frame of that bit is bright at y in [0, 1].
bool is_bright(const Code& code, int bit, double y);

/// What the code says of one pixel.
struct CodeReading {
  int stripe = 0;  ///< counted from 0 at y = 0; past the last one where no stripe has that word
  /// How far the frames of the bits are from where bright turns to dark, grey levels: the second
  /// least of all bits (at a stripe's edge one of them is rightly in between), the least of one.
  double contrast = 0;
};

/// `intensities`: of all frames of the scan, one pixel's.
CodeReading read_code(const Code& code, std::span<const double> intensities);

/// The bits of a word, from those that frames show, most significant first.
int stripe_of(const Code& code, unsigned shown);

/// Where a run's phase begins and which way its shifts go: pattern n has the phase 2 pi f y +
/// origin
/// - 2 pi n / N, or + 2 pi n / N backwards.
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

/// A sinusoid in the frames of a scan, as one complex number for each pixel: C + i S =
/// B exp(i phi), C = sum cosine[n] I_n and S = sum sine[n] I_n, of mean A = sum mean[n] I_n. Liu
/// 2010, Eqs. (1.3), (1.5), (1.6) are the band of N-step patterns; any other weights will do for
/// which the frames shown give C = B cos(phi), S = B sin(phi).
struct Band {
  double periods = 1;            ///< across the projector's field, > 0
  double share = 1;              ///< of the modulation: B over alpha alpha_p / 2, (0, 1]
  std::vector<double> cosine{};  ///< a weight for each frame of the scan, as `sine` and `mean`
  std::vector<double> sine{};
  std::vector<double> mean{};
  /// Periods of a carrier across the axis; 0: none. Frames with one show cos(pi periods y) times
  /// cos(2 pi carrier x), which is the sum of two oblique sinusoids, or these by themselves. C + i
  /// S is then the one, of the phase pi periods y + 2 pi carrier x, with its own mean; the other,
  /// of pi periods y - 2 pi carrier x, is `mirrored`. In the sum of their phases, which is the
  /// band's, the carrier is no more; B is the lesser of theirs.
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

/// A real number for each pixel that is monotonic in the coordinate, in frames that hold a band
/// too: sum weights[n] I_n = dc (alpha (alpha_p / 2 + beta_p + beta) + beta) + alpha alpha_p share
/// R(y) / 2 with dc = sum weights[n], Eqs. (3.56), (3.73).
struct Cue {
  double share = 0.5;             ///< of the modulation: c_2, (0, 1)
  std::vector<double> weights{};  ///< one for each frame of the scan
  CueReference reference{};

  /// What a constant light in all frames counts for: 1 in the DC channel, where the cue cannot be
  /// read without knowing the ambient light; 0 in the half phase channel.
  [[nodiscard]] double dc() const;

  friend bool operator==(const Cue&, const Cue&) = default;
};

/// A frame that shows a sinusoid alone, with the mean and the modulation of the first band: mean +
/// B cos(2 pi periods y + origin).
struct SingleFrame {
  int frame = 0;
  double periods = 1;
  double origin = 0;  ///< rad

  friend bool operator==(const SingleFrame&, const SingleFrame&) = default;
};

/// How phases become a projector coordinate. What each one means for the rest is said by its
/// UnwrappingWay: see unwrapping.h.
enum class Unwrapping {
  none,           ///< one band of at most one period needs nothing; of more it gives no coordinate
  hierarchical,   ///< each band, from few periods to many, is unwrapped by the one before: Eq.
                  ///< (1.17)
  surfaces,       ///< each connected surface by the order under which its single frames fit best
  vote,           ///< the cue, or a second band in the same frames, and the neighbours: Section 3.2
  beats,          ///< hierarchical, by whole sums and differences of the bands' phases (heterodyne)
  likelihood,     ///< the coordinate under which all bands together are likeliest
  code,           ///< the code names the period of the measuring band: Eq. (1.18)
  code_alone,     ///< the middle of the code's stripe
  single_frames,  ///< the coordinate under which the first band and all single frames are likeliest
};

/// What the frames of a scan hold: all that decoding, prediction and calibration must know of a
/// strategy.
struct Layout {
  int frames = 0;
  /// At least one. With Unwrapping::vote the first one measures, and a second one of one period is
  /// its cue; else the order is free.
  std::vector<Band> bands{};
  std::optional<Cue> cue{};                  ///< with Unwrapping::vote, where there is one band
  std::optional<Code> code{};                ///< with Unwrapping::code and code_alone
  std::vector<SingleFrame> single_frames{};  ///< with Unwrapping::single_frames, a run of steps
                                             ///< first; with surfaces of at most one period
  Unwrapping unwrapping = Unwrapping::none;

  friend bool operator==(const Layout&, const Layout&) = default;
};

/// Throws Error, beginning with `name`, unless there are bands, each with a weight for each frame,
/// finite, without response to constant light in C and S and with a response of 1 in the mean;
/// periods and shares are in range, and the unwrapping has what it needs: hierarchical one band of
/// at most one period, beats and likelihood bands that together repeat nowhere in the field, vote a
/// cue or a second band, code one whose stripes are no wider than a period.
void require_valid(const Layout& layout, std::string_view name);

/// Throws Error, beginning with `name`, unless the cue has a weight for each frame, which add up to
/// 0 or 1, and a share between 0 and 1.
void require_valid(const Cue& cue, int frames, std::string_view name);

/// The band of N phase-shifted sinusoids, from frame `first` of `frames` on: 2/N cos(2 pi m n / N),
/// 2/N sin(2 pi m n / N) and 1/N, m the phase channel: 1 for Eqs. (1.5), (1.6), 2 for (3.85),
/// (3.86); turned as `shifts` say.
Band phase_shifted_band(int frames, int first, int steps, double periods, int channel = 1,
                        double share = 1, const Shifts& shifts = {});

/// The weights of a channel alone, for N frames.
std::vector<double> channel_cosines(int steps, int channel);
std::vector<double> channel_sines(int steps, int channel);
/// Of the DC channel, (1.3), and of the half phase channel of 4 frames, (3.70).
std::vector<double> mean_weights(int steps);
std::vector<double> half_phase_weights();

/// The run whose first phase channel the band is, with a carrier the first of its sinusoids; none
/// where its weights are others. For N = 3, 4,
/// 6 there are tables then, and for any N a response can be corrected.
std::optional<StepRun> step_run(const Band& band);
/// The steps, in the frames or in the cycle that they come from, under which a bent response bends
/// the band's phase.
std::optional<StepRun> bent_run(const Band& band);
/// Whether the band is that phase channel of the run.
bool is_channel(const Band& band, const StepRun& run, int channel);

/// Variance of C and of S, on average, over that of a frame: 2 / N for N steps, Eq. (3.36). With a
/// carrier the mirrored ones' is added, as the phase has the noise of both.
double component_noise(const Band& band);

/// N of each band that has a bent_run, in the order of the bands.
std::vector<int> step_counts(const Layout& layout);

/// Indices of the bands, from few periods to many.
std::vector<std::size_t> coarse_to_fine(const Layout& layout);
/// The band whose phase gives the coordinate.
const Band& measuring_band(const Layout& layout);
std::size_t measuring_band_index(const Layout& layout);
/// The frames whose levels count, not only which of them is brighter: all but those of a code.
std::vector<int> measuring_frames(const Layout& layout);

/// Whether the frames alone give the projector coordinate, and so a depth.
bool has_coordinate(const Layout& layout);
/// Whether that takes the ambient light: a cue in the DC channel.
bool needs_ambient_light(const Layout& layout);
/// Most periods of a carrier; 0 where no pattern varies across the axis.
double carrier_periods(const Layout& layout);
/// Most periods across the field.
double highest_frequency(const Layout& layout);

}  // namespace slipstream
