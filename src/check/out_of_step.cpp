// Frames that contain a share of the pattern before: exposures that span two patterns.
#include "check/out_of_step.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>
#include <tuple>
#include <vector>

#include "base/statistics.h"
#include "check/mistake_search.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

// Right scans have less: a residual by noise, and a share in code by blur.
constexpr double least_residual = 0.003, most_in_code = 0.04;

constexpr double least_share = 0.015;  // of the pattern before, in each frame

/// Frame n contains the share s of the pattern before: I_n = (1 - s) P_n + s P_(n-1).
struct Mixture {
  std::vector<StepRun> runs;   ///< before the first frame of each is its last
  bool stands = false;         ///< unless the first pattern was shown long before
  bool after = false;          ///< the other way round: a share of the pattern after
  double top = 0, bottom = 0;  ///< s in the first and last row: a rolling shutter exposes in turns

  [[nodiscard]] double mean() const { return (top + bottom) / 2; }

  /// Recovers P from I, in place. `down`: the row, share of the picture's height.
  void undo(float* I, double down) const {
    const double s = top + (bottom - top) * down, r = s / (1 - s);

    for (const StepRun& run : runs) {
      float* const frames = I + run.first;
      if (after) std::reverse(frames, frames + run.steps);
      double P = 0;  // of the last frame, by substitution for all before it
      for (int n = 0; n < run.steps; ++n) P = frames[n] - r * P;

      // In a repeated cycle the pattern before the first is the last: solve for it.
      P = stands ? frames[0] : P / ((1 - s) * (1 - std::pow(-r, run.steps)));

      // Then forwards, each frame without its share of the pattern before.
      for (int n = 0; n < run.steps; ++n) {
        P = (frames[n] - s * P) / (1 - s);
        frames[n] = static_cast<float>(P);
      }

      if (after) std::reverse(frames, frames + run.steps);
    }
  }
};

constexpr double half = 0.5;  // hides what alternates from frame to frame

/// How bright each frame's bright pixels are, as a share of the brightest frame there; 1 if it has
/// hardly any. A frame that differs has another exposure.
std::vector<float> bright_levels(const ScanSamples& samples, std::size_t groups) {
  constexpr double nearly_all = 0.95;
  constexpr float darkest = 0.3F;

  std::vector<float> levels;
  for (int n = 0; n < samples.frames(); ++n) {
    std::vector<float> shares;
    for (std::size_t g = 0; g < groups; ++g) {
      const float* const I = samples.levels(g, ScanSamples::middle);
      shares.push_back(I[n] / *std::max_element(I, I + samples.frames()));
    }

    const float bright = shares.empty() ? 1.0F : quantile(shares, nearly_all);
    levels.push_back(bright < darkest ? 1.0F : bright);
  }

  return levels;
}

/// The share in the frames of a code, 0 if unknown: bits unlike the bit before lose contrast, all
/// of it at one half.
double share_in_code(const FrameModel& model, const ScanSamples& samples) {
  constexpr std::size_t most_groups = 256;
  // Pixels; share of the range; share of the bits with wide stripes: right scans have few between.
  constexpr double fewest = 16, no_contrast = 0.1, most_without = 0.25;

  const auto& code = model.layout().code;
  double sum = 0, weights = 0, without = 0, wide = 0;
  if (!code || code->base) return 0;  // edges of a common base are in all frames

  const std::size_t groups = std::min(samples.groups(), most_groups);
  const std::vector<float> bright = bright_levels(samples, groups);

  for (std::size_t bit = 1; bit < code->frames.size(); ++bit) {
    const int n = code->frames[bit], before = n - 1;
    if (before != code->frames[bit - 1]) continue;

    // Contrast of this bit where it is like the bit before and where it is not.
    double alike = 0, unlike = 0, alike_count = 0, unlike_count = 0;
    for (std::size_t g = 0; g < groups; ++g) {
      const float* const I = samples.levels(g, ScanSamples::middle);
      const auto [least, greatest] = std::minmax_element(I, I + samples.frames());

      const float middle = (*least + *greatest) / 2;
      const double contrast = std::abs(I[n] - middle) / (*greatest - *least);

      const bool is_alike = (I[n] > middle) == (I[before] > middle);
      (is_alike ? alike : unlike) += contrast;
      (is_alike ? alike_count : unlike_count) += 1;

      // The coarser half of the bits has wide stripes.
      if (2 * bit > code->frames.size()) continue;
      wide += 1;
      const double exposed = std::abs(I[n] / bright[n] - middle) / (*greatest - *least);
      without += std::max(contrast, exposed) < no_contrast ? 1 : 0;
    }

    // A share s of the bit before takes 2 s of the contrast where the bits differ.
    const double weight = std::min(alike_count, unlike_count);
    if (weight < fewest) continue;

    sum += weight * (1 - unlike / unlike_count * alike_count / alike) / 2;
    weights += weight;
  }

  if (without > most_without * wide) return half;
  return weights > 0 ? std::max(0.0, sum / weights) : 0;
}

class MixtureSearch {
 public:
  /// `fits`: whether the scan fits as it is.
  MixtureSearch(const JudgedScan& scan, bool fits)
      : scan_(scan), fits_(fits), judge_(scan.model), few_(scan.samples) {
    constexpr std::size_t few = 96;
    few_.keep_first(few);
  }

  /// The misfit of few pixels, by the frames alone.
  [[nodiscard]] double misfit(const Mixture& mixture) {
    return Fit{.frames = judge_(undone(mixture, few_), scan_.model.identity())}.misfit();
  }

  [[nodiscard]] static ScanSamples undone(const Mixture& mixture, ScanSamples samples) {
    samples.change([&](float* I, double down) { mixture.undo(I, down); });
    return samples;
  }

  /// The mixture with the pattern before, or after, that explains the frames best; a share of 0 if
  /// none does better than none.
  [[nodiscard]] Mixture best(bool after) {
    const double as_given = misfit({});
    Mixture found;
    double least = as_given;

    for (Mixture& way : ways(after)) {
      // The same share in all rows, or one that grows down or up the picture.
      for (const auto& [at_top, at_bottom] : {std::pair{1, 1}, std::pair{0, 2}, std::pair{2, 0}}) {
        for (double s = 0.02; s < most / std::max(at_top, at_bottom); s += s < 0.05 ? 0.02 : 0.04) {
          way.top = s * at_top;
          way.bottom = s * at_bottom;

          const double then = misfit(way);
          // A right scan fits worse with any share.
          if (fits_ && s < 0.03 && then >= as_given) break;
          if (then < least) std::tie(found, least) = std::pair(way, then);
        }
      }
    }

    improve(found, least);
    return found;
  }

  /// The mixture with a share that the code shows and the bands do not.
  [[nodiscard]] Mixture of_code(double share) const {
    Mixture mixture = in_bands();
    mixture.top = mixture.bottom = std::min(share, most);
    return mixture;
  }

 private:
  static constexpr double most = half - 0.01;

  [[nodiscard]] std::vector<Mixture> ways(bool after) const {
    const std::vector<StepRun> all{{0, scan_.samples.frames()}};
    // A share from frame to frame, with or without a pause before or after the cycle, or band by
    // band, where a share of the pattern after looks like another one of the pattern before.
    std::vector<Mixture> ways{
        {.runs = all, .after = after}, {.runs = all, .stands = true, .after = after}, in_bands()};
    if (after || ways.back().runs.size() < 2) ways.pop_back();
    return ways;
  }

  [[nodiscard]] Mixture in_bands() const { return {.runs = step_runs(scan_.model.layout())}; }

  void improve(Mixture& mixture, double& least) {
    // Halve the step once no direction improves the fit.
    for (double step = 0.02; mixture.mean() > 0 && step > 0.002;) {
      const double before = least;
      for (const auto& [at_top, at_bottom] :
           {std::pair{1, 1}, std::pair{-1, -1}, std::pair{-1, 1}, std::pair{1, -1}}) {
        Mixture next = mixture;
        next.top = std::clamp(mixture.top + at_top * step, 0.0, most);
        next.bottom = std::clamp(mixture.bottom + at_bottom * step, 0.0, most);

        const double then = misfit(next);
        if (then < least) std::tie(mixture, least) = std::pair(next, then);
      }

      if (least == before) step /= 2;
    }
  }

  const JudgedScan& scan_;
  bool fits_;
  FrameJudge judge_;
  ScanSamples few_;
};

/// Median error of the coordinate, fields, and of the depth, mm (0 without a scanner).
std::pair<double, double> errors(const JudgedScan& scan, const ScanSamples& undone, const Fit& fit,
                                 const Fit& then) {
  const FrameOrder order = scan.model.identity();
  SampleReading wrong, right;
  std::vector<double> off;

  for (std::size_t g = 0; g < undone.groups(); ++g) {
    scan.model.read(scan.samples.levels(g, ScanSamples::middle), order, wrong);
    scan.model.read(undone.levels(g, ScanSamples::middle), order, right);
    off.push_back(std::abs(wrong.coordinate - right.coordinate));
  }

  const double deeper =
      fit.geometry ? std::abs(fit.geometry->median_depth - then.geometry->median_depth) : 0;
  return {quantile(off, 0.5), deeper};
}

/// Whether a scan that fits leaves anything to explain.
bool is_suspect(const Fit& fit, bool has_cue, double in_code) {
  constexpr double most_offset = 0.04;  // right scans: less, but blur moves a cue's
  const auto is_off = [](const BandRelation& relation) {
    return std::abs(relation.offset) > most_offset + 3 * relation.error;
  };

  return !fit.all() || fit.frames.residual > least_residual || in_code > most_in_code ||
         std::ranges::any_of(fit.frames.relations | std::views::drop(has_cue ? 1 : 0), is_off);
}

/// The finding, with the harm that the share did.
Finding out_of_step(const Mixture& mixture, const std::pair<double, double>& harm, double in_code) {
  const auto [off, deeper] = harm;

  // Fields: about the noise of one pixel; mm; a share: bits begin to err at a quarter.
  constexpr double most_off = 2e-4, most_deeper = 0.7, harmful_in_code = 0.15;
  const bool is_harmful = off > most_off || deeper > most_deeper || in_code > harmful_in_code;

  Finding finding{
      .kind = FindingKind::mixed_frames,
      .severity = is_harmful ? Severity::wrong : Severity::doubtful,
      .what = fmt::format("each frame contains a share of the pattern {}",
                          mixture.after ? "after it" : "before"),
      .evidence = {{"share", 100 * mixture.mean(), "percent", 100 * least_share},
                   {"coordinates off by", 100 * off, "percent of the field", 100 * most_off}},
      .causes = {{CauseKind::out_of_step,
                  "camera and projector out of step: exposures span two patterns"},
                 {CauseKind::unclear, "an object that moved during capture"}},
      .remedies = {{fmt::format("trigger the camera by the projector, or expose {} and for whole "
                                "patterns",
                                mixture.after ? "earlier" : "later")},
                   {"hold the object still"}}};

  if (deeper > 0) {
    finding.evidence.push_back({"median depth off by", deeper, "mm", most_deeper});
  }

  // A rolling shutter exposes row after row, so that the share changes down the picture.
  if (std::abs(mixture.top - mixture.bottom) > mixture.mean()) {
    finding.evidence.push_back({"top row", 100 * mixture.top, "percent"});
    finding.evidence.push_back({"bottom row", 100 * mixture.bottom, "percent"});
    finding.causes.front().text += " by a rolling shutter";
  }

  return finding;
}

/// Whether the scan without that share fits, and clearly better. `in_code`: the share that the code
/// shows.
bool explains_better(const JudgedScan& scan, const Fit& fit, const Fit& then, double in_code) {
  constexpr double most_left = 0.5, better = 0.3;
  const bool by_code = in_code > most_in_code, is_half = in_code == half;

  // Near a share of one half, noise remains of a code's frames; at one half none can be undone.
  if (!is_half && (!then.patterns_made() || !then.bands_agree() ||
                   (!by_code && (!then.geometry_fits() || then.misfit() >= fit.misfit())))) {
    return false;
  }

  // What moves may resemble a share, but leaves more.
  const bool explained = fit.frames.residual > least_residual
                             ? then.frames.residual < most_left * fit.frames.residual
                             : then.misfit() < fit.misfit() - better;
  return (!fit.all() && !scan.settings.moving) || by_code || explained;
}

}  // namespace

std::optional<MixedFrames> mixed_frames(const JudgedScan& scan, const Fit& fit) {
  const double in_code = share_in_code(scan.model, scan.samples);
  // In windows of declared motion the frame before a cycle is another one each time.
  if (measuring_band(scan.model.layout()).cycle ||
      !is_suspect(fit, scan.model.has_real_cue(), in_code))
    return std::nullopt;

  MixtureSearch search(scan, fit.all());
  for (const bool after : {false, true}) {
    // 1. The share that explains the frames best, or else the code.
    Mixture mixture = search.best(after);
    const double of_code = after ? 0 : in_code;  // a code shows a share of the pattern before alone
    if (mixture.mean() < least_share && !after) mixture = search.of_code(in_code);
    if (mixture.mean() < least_share) continue;

    // So large a share would have taken the contrast of a code that is alone.
    constexpr double hardly_hidden = 0.45;
    const bool alone = scan.model.layout().unwrapping->whole_stripes;
    if (alone && of_code <= most_in_code && mixture.mean() > hardly_hidden) continue;

    // 2. The scan without that share.
    const ScanSamples undone = search.undone(mixture, scan.samples);
    const Fit then =
        fit_of({scan.model, undone, scan.sequence, scan.scanner, scan.photometry, scan.settings});
    if (!explains_better(scan, fit, then, of_code)) continue;

    // 3. The harm done.
    return MixedFrames{then.misfit(),
                       out_of_step(mixture, errors(scan, undone, fit, then), of_code)};
  }

  return std::nullopt;
}

}  // namespace slipstream
