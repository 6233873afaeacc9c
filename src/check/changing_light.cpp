#include "check/changing_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "check/mistake_search.h"

namespace slipstream {
namespace {

/// Inverse gains: frame n without the change is (1 - gains[n]) I_n. The mean is 0.
struct FrameGains {
  /// Adds the equations of other pixels.
  void add(const FrameGains& more) {
    normal += more.normal;
    right += more.right;
    all += more.all;
    variation += more.variation;
    pairs += more.pairs;
  }

  /// A common gain is unobservable: fixes the mean at 0.
  void solve() {
    const Eigen::Index count = right.size();
    const double held = normal.trace() / static_cast<double>(std::max<Eigen::Index>(1, count));
    gains = solve_symmetric(normal + Eigen::MatrixXd::Constant(count, count, held), right);
  }

  /// The part of `all` that `others`, gains from other pixels, explain.
  [[nodiscard]] double explained_by(const Eigen::VectorXd& others) const {
    return others.dot(2 * right - normal * others);
  }

  [[nodiscard]] double residual() const {
    return variation > 0 ? std::sqrt(std::max(0.0, all / variation)) : 0;
  }

  std::vector<int> frames{};  ///< of each gain
  Eigen::VectorXd gains{};
  Eigen::MatrixXd normal{};  ///< normal * gains = right, with residual `all`
  Eigen::VectorXd right{};
  double all = 0, variation = 0;
  int pairs = 0;  ///< of pixels that were compared
};

/// A frame and how much brighter it is than the usual one, a share, or a level of it.
struct FrameGain {
  int frame = 0;
  double gain = 0;
};

double brightness_of(double inverse_gain) {
  constexpr double largest = 0.95;
  return 1 / (1 - std::min(inverse_gain, largest));
}

/// The frame whose gain alone explains nearly all, and more than any other's.
std::optional<FrameGain> odd_frame(const FrameGains& gains) {
  constexpr double least_share = 0.7, least_lead = 0.1;
  std::optional<FrameGain> best;

  double most = 0, second = 0;
  for (Eigen::Index n = 0; n < gains.right.size(); ++n) {
    const double right = gains.right[n];
    const double normal = gains.normal(n, n);

    // Part of the residual that the gain of frame n alone explains by least squares.
    const double share = normal > 0 && gains.all > 0 ? right * right / normal / gains.all : 0;
    second = std::max(second, std::min(share, most));
    if (share <= most) continue;
    most = share;
    best = FrameGain{gains.frames[n], brightness_of(right / normal) - 1};
  }

  // The clearest frame must stand out from the second.
  return most >= least_share && most >= second + least_lead ? best : std::nullopt;
}

/// Whether frames contradict each other only at the coordinate that they give: their shapes explain
/// any intensities if each may lie anywhere.
bool is_compared_by_place(const FrameModel& model) {
  const Layout& layout = model.layout();
  const Band& band = measuring_band(layout);
  return model.unexplained_count() == 0 && model.has_coordinate() && !layout.code &&
         band.carrier == 0 && !band.cycle;
}

/// The frames that an unexplained component contains: not a code's whose bits are all there is.
std::vector<int> compared_frames(const FrameModel& model, bool by_place) {
  constexpr double least = 1e-6;

  std::vector<int> frames;
  for (int n = 0; n < model.layout().frames; ++n) {
    if (by_place || model.unexplained_by(n, 1).norm() > least) frames.push_back(n);
  }
  return frames;
}

/// The residual of a pixel's frames, and its derivative by the inverse gain of each: columns.
struct PixelResidual {
  Eigen::VectorXd left;
  Eigen::MatrixXd by_gains;
  double coordinate = 0;
};

/// Replaces `residual`. P I is 0 for true frames, so that gains leave P diag(I) gain.
void read_residual(const FrameModel& model, const float* levels, const std::vector<int>& frames,
                   SampleReading& reading, PixelResidual& residual) {
  model.read(levels, model.identity(), reading);
  residual.coordinate = reading.coordinate;
  const auto count = static_cast<Eigen::Index>(frames.size());

  if (is_compared_by_place(model)) {
    residual.by_gains = model.unexplained_at(reading);
    for (Eigen::Index i = 0; i < count; ++i) residual.by_gains.col(i) *= double{levels[i]};
    residual.left = residual.by_gains.rowwise().sum();
    return;
  }

  const auto rows = static_cast<Eigen::Index>(model.unexplained_count());
  residual.left = Eigen::Map<const Eigen::VectorXd>(reading.unexplained.data(), rows);
  residual.by_gains.resize(rows, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    residual.by_gains.col(i) = model.unexplained_by(frames[i], double{levels[frames[i]]});
  }
}

/// Strips of the picture, one below the other: under flickering light a rolling shutter gives each
/// its own gains.
constexpr int strips = 8;

/// The one of `count` strips that holds a row so far down the picture.
std::size_t strip_of(double down, std::size_t count) {
  return static_cast<std::size_t>(down * static_cast<double>(count));
}

/// The gains of each strip from every other group, from `first` (0 or 1) on.
std::vector<FrameGains> strip_gains(const FrameModel& model, const ScanSamples& samples,
                                    std::size_t first) {
  // Fields: pixels farther apart lie beside an edge, or have another fringe order.
  constexpr double most_apart = 0.03;

  const bool by_place = is_compared_by_place(model);
  const std::vector<int> frames = compared_frames(model, by_place);
  const auto count = static_cast<Eigen::Index>(frames.size());
  std::vector<FrameGains> found(strips, {.frames = frames,
                                         .normal = Eigen::MatrixXd::Zero(count, count),
                                         .right = Eigen::VectorXd::Zero(count)});

  SampleReading reading;
  PixelResidual a, b;

  // Normal equations. Both factors of each product come from different neighbours, which share no
  // noise; each pair is used both ways round.
  for (std::size_t g = first; g < samples.groups(); g += 2) {
    if (!samples.lit(g, ScanSamples::right)) continue;

    const float* const levels = samples.levels(g, ScanSamples::middle);
    read_residual(model, levels, frames, reading, a);
    read_residual(model, samples.levels(g, ScanSamples::right), frames, reading, b);
    if (by_place && std::abs(a.coordinate - b.coordinate) > most_apart) continue;

    found[strip_of(samples.down(g), strips)].add(
        {.normal = a.by_gains.transpose() * b.by_gains + b.by_gains.transpose() * a.by_gains,
         .right = a.by_gains.transpose() * b.left + b.by_gains.transpose() * a.left,
         .all = 2 * a.left.dot(b.left),
         .variation = 2 * samples.variation(levels),
         .pairs = 1});
  }

  for (FrameGains& strip : found) strip.solve();
  return found;
}

/// The gains of the whole picture.
FrameGains joined(const std::vector<FrameGains>& parts) {
  FrameGains whole = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) whole.add(parts[i]);
  whole.solve();
  return whole;
}

/// Whether the frames of a code have one gain, and the others another, as if the response were not
/// linear: a code shows only black and white, the others also the grey levels between.
bool parts_code(const FrameGains& gains, const std::optional<Code>& code) {
  constexpr double most_within = 0.2;  // share of the gains' sum of squares
  if (!code) return false;

  std::array<double, 2> count{}, sum{}, squares{};
  for (std::size_t i = 0; i < gains.frames.size(); ++i) {
    const int n = gains.frames[i];
    const double gain = gains.gains[static_cast<Eigen::Index>(i)];
    const bool in_code =
        std::ranges::count(code->frames, n) > 0 || std::ranges::count(code->inverses, n) > 0;

    const std::size_t kind = in_code ? 1 : 0;
    count[kind] += 1;
    sum[kind] += gain;
    squares[kind] += gain * gain;
  }
  if (count[0] == 0 || count[1] == 0) return false;

  // Sums of squares about the mean of each kind, and about the mean of all.
  const double within =
      squares[0] - sum[0] * sum[0] / count[0] + squares[1] - sum[1] * sum[1] / count[1];
  const double in_all =
      squares[0] + squares[1] - std::pow(sum[0] + sum[1], 2) / (count[0] + count[1]);
  return within < most_within * in_all;
}

/// The finding about frames that differ from the usual one; `limit`: of their gains.
Finding finding_of(const std::vector<FrameGain>& gains, double limit) {
  const auto [darkest, brightest] = std::ranges::minmax_element(gains, {}, &FrameGain::gain);

  Finding finding{
      .kind = FindingKind::changing_light,
      .what =
          fmt::format("frames are over {:.2g} % brighter or darker than the patterns", 100 * limit),
      .causes = {{CauseKind::flicker,
                  "light that flickers, or automatic exposure, gain or white balance"}},
      .remedies = {{"switch off automatic exposure, gain and white balance; expose for whole "
                    "periods of the mains and the projector"}}};

  const auto add = [&](const FrameGain& of) {
    finding.evidence.push_back(
        {fmt::format("frame {}", of.frame), 100 * of.gain, "percent", 100 * limit});
  };
  if (std::abs(darkest->gain) > limit) add(*darkest);
  if (std::abs(brightest->gain) > limit && brightest != darkest) add(*brightest);

  for (const FrameGain& of : gains) {
    if (std::abs(of.gain) > limit) finding.frames.push_back(of.frame);
  }

  return finding;
}

/// How much brighter each frame is than the median one; 0 for all if noise may cause it.
std::vector<FrameGain> relative_gains(const FrameGains& gains, const FrameGains& others) {
  std::vector<FrameGain> relative;
  std::vector<double> all;

  for (Eigen::Index i = 0; i < gains.gains.size(); ++i) {
    all.push_back(brightness_of((gains.gains[i] + others.gains[i]) / 2));
    relative.push_back({gains.frames[i], all.back()});
  }

  const double usual = quantile(all, 0.5);
  for (FrameGain& of : relative) of.gain = of.gain / usual - 1;

  // The standard error, from the two halves of the pixels: gains near it are noise.
  const double error = (gains.gains - others.gains).norm() / (2 * std::sqrt(gains.gains.size()));
  double largest = 0;
  for (const FrameGain& of : relative) largest = std::max(largest, std::abs(of.gain));
  if (!(largest >= 4 * error)) {
    for (FrameGain& of : relative) of.gain = 0;
  }
  return relative;
}

/// The gains of all frames, in each part of the picture.
using PartGains = std::vector<std::vector<FrameGain>>;

/// The misfit of the scan without these gains; infinite if it does not fit.
double misfit_without(const JudgedScan& scan, const PartGains& parts) {
  ScanSamples samples = scan.samples;
  samples.change([&](float* I, double down) {
    for (const auto& [frame, gain] : parts[strip_of(down, parts.size())]) {
      I[frame] /= static_cast<float>(1 + gain);
    }
  });

  const Fit fit =
      fit_of({scan.model, samples, scan.sequence, scan.scanner, scan.photometry, scan.settings});
  return fit.all() ? fit.misfit() : std::numeric_limits<double>::infinity();
}

/// Of each frame its largest gain.
std::vector<FrameGain> largest_gains(const PartGains& parts) {
  std::vector<FrameGain> largest = parts.front();
  for (const std::vector<FrameGain>& part : parts) {
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (std::abs(part[i].gain) > std::abs(largest[i].gain)) largest[i] = part[i];
    }
  }
  return largest;
}

/// Light that changed by more than frames that redundancy compares allow, in parts of the picture:
/// by the gains of one half of its pixels, and those of the other.
std::optional<ChangedLight> by_gains(const JudgedScan& scan, const std::vector<FrameGains>& gains,
                                     const std::vector<FrameGains>& others) {
  // Correct scans sometimes leave more (a real skull: 0.0085), but gains explain at most 0.62 of
  // it, at half a percent. At their places frames are compared less exactly.
  constexpr double least_gain = 0.025;
  const double least_explained = is_compared_by_place(scan.model) ? 0.6 : 0.7;

  // Other faults look like larger gains, but these do not explain all of them.
  constexpr double large_gain = 0.3, all_explained = 0.95;

  // Noise may look like gains: those of one half of the pixels must explain the other half.
  PartGains relative;
  double explained = 0, all = 0;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    relative.push_back(relative_gains(gains[i], others[i]));
    explained += gains[i].explained_by(others[i].gains) + others[i].explained_by(gains[i].gains);
    all += gains[i].all + others[i].all;
  }

  std::vector<FrameGain> largest = largest_gains(relative);
  double size = 0;
  for (const FrameGain& of : largest) size = std::max(size, std::abs(of.gain));
  if (!(explained >= least_explained * all && size >= least_gain)) return std::nullopt;

  const bool whole = gains.size() == 1;
  const auto odd = whole ? odd_frame(gains.front()) : std::nullopt;
  // Motion may resemble flicker, but rarely of a single frame.
  if (scan.settings.moving && !odd) return std::nullopt;

  const double misfit = misfit_without(scan, relative);
  if (size > large_gain && (explained < all_explained * all || !std::isfinite(misfit))) {
    return std::nullopt;
  }

  if (odd && std::abs(odd->gain) > least_gain) largest = {*odd};
  ChangedLight changed{misfit, finding_of(largest, least_gain)};
  if (size > large_gain) changed.finding.severity = Severity::wrong;
  if (!whole) changed.finding.what += " in some of their rows";
  if (whole && !scan.photometry.response && parts_code(gains.front(), scan.model.layout().code)) {
    Finding& finding = changed.finding;
    finding.causes.insert(finding.causes.begin(),
                          {CauseKind::gamma, "the projector's gamma, if it is not 1"});
    finding.remedies.insert(finding.remedies.begin(),
                            {"measure the gamma with `calibrate_gamma()`"});
  }

  return changed;
}

/// Difference of a bit and its inverse as a share of their sum.
double pair_contrast(const Code& code, const float* I, std::size_t bit) {
  const double shown = I[code.frames[bit]], inverse = I[code.inverses[bit]];
  return std::abs(shown - inverse) / std::max(1.0, shown + inverse);
}

/// The bright frame of each bit at a pixel, with the sum of the bit and its inverse, which blur
/// leaves as it is. A response does not, so that blurred bits are left out.
std::vector<FrameGain> bright_frames(const Code& code, const float* I) {
  constexpr double least_contrast = 0.8;  // of the pixel's sharpest bit
  const std::size_t bits = code.frames.size();
  std::vector<FrameGain> bright;

  double sharpest = 0;
  for (std::size_t bit = 0; bit < bits; ++bit) {
    sharpest = std::max(sharpest, pair_contrast(code, I, bit));
  }

  for (std::size_t bit = 0; bit < bits; ++bit) {
    if (pair_contrast(code, I, bit) < least_contrast * sharpest) continue;
    const int shown = code.frames[bit], inverse = code.inverses[bit];
    bright.push_back({I[inverse] > I[shown] ? inverse : shown, double{I[shown]} + I[inverse]});
  }

  return bright;
}

}  // namespace

std::optional<ChangedLight> changed_light(const JudgedScan& scan, const Fit& fit) {
  // Brightness that changes between frames moves no bit that is compared with its inverse.
  if (fit.code.bits_are_sure()) return std::nullopt;

  constexpr double least_residual = 0.003;
  if (!is_compared_by_place(scan.model) && fit.frames.residual < least_residual) {
    return std::nullopt;
  }

  std::vector<FrameGains> gains = strip_gains(scan.model, scan.samples, 0);
  std::vector<FrameGains> others = strip_gains(scan.model, scan.samples, 1);
  const FrameGains whole = joined(gains);
  if (whole.frames.empty() || whole.residual() < least_residual) return std::nullopt;

  if (auto changed = by_gains(scan, {whole}, {joined(others)})) return changed;

  // A strip shows few places of patterns along y, where an error of the patterns' shape, as by
  // blur, looks like gains.
  if (is_compared_by_place(scan.model) && scan.sequence.axis == Axis::y) return std::nullopt;

  // A strip of few pixels, as of a small picture or beside the object, shows the surface's form.
  constexpr int fewest = 80;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    if (std::min(gains[i].pairs, others[i].pairs) >= fewest) continue;
    gains[i].gains.setZero();
    others[i].gains.setZero();
  }
  return by_gains(scan, gains, others);
}

std::optional<Finding> changed_light_of_code(const JudgedScan& scan) {
  // Without inverses, blur and light between surfaces change a bit's brightness as well.
  constexpr double most = 0.2;
  constexpr std::size_t fewest_pixels = 32;

  const auto& code = scan.model.layout().code;
  if (!code || code->inverses.empty()) return std::nullopt;

  // 1. Of each frame, its bright pixels over the usual brightness of each.
  std::vector<std::vector<double>> ratios(scan.samples.frames());
  for (std::size_t g = 0; g < scan.samples.groups(); ++g) {
    const std::vector<FrameGain> bright =
        bright_frames(*code, scan.samples.levels(g, ScanSamples::middle));
    if (bright.size() < 2) continue;

    std::vector<double> levels;
    for (const FrameGain& of : bright) levels.push_back(of.gain);
    const double usual = quantile(levels, 0.5);
    for (const auto& [frame, level] : bright) ratios[frame].push_back(level / usual);
  }

  // 2. The frames that differ.
  std::vector<FrameGain> gains;
  double largest = 0;
  for (int n = 0; n < scan.samples.frames(); ++n) {
    if (ratios[n].size() < fewest_pixels) continue;
    gains.push_back({n, quantile(ratios[n], 0.5) - 1});
    largest = std::max(largest, std::abs(gains.back().gain));
  }

  if (largest <= most) return std::nullopt;
  return finding_of(gains, most);
}

}  // namespace slipstream
