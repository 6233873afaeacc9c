#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <string_view>
#include <vector>

#include "check/code_evidence.h"
#include "check/frame_model.h"
#include "check/geometry_evidence.h"
#include "check/waveform.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Each limit separates correct scans (real ones, and virtual ones with noise) from mistaken ones;
/// tests/check measures both.
struct FitLimits {
  // Correct scans: agreement above 0.69 (real skull 0.81), offset below 0.05. A wrong number of
  // periods or frame order nearly always gives less than 0.6 or more than 0.1.
  static constexpr double least_agreement = 0.6, most_offset = 0.1;
  // Correct scans: 0.014, real ones of twelve steps 0.07; with two frames swapped 0.15 to 0.4.
  static constexpr double most_residual = 0.1;
  static constexpr double hopeless_residual = 0.15;     // beyond this no pixel is right
  static constexpr double most_residual_moving = 0.25;  // motion between frames: up to 0.15
  // Correct scans: 0.31, a real skull 0.43; with frames of two bands mixed up 0.7.
  static constexpr double most_ratio_spread = 0.6, most_seams = 0.015;
  // Slanted surfaces change the slope: median 0.58 to 1.8 in correct scans.
  static constexpr double least_slope = 0.35, most_slope = 2.8;
  // A lost bit turns the coordinate's direction in half of the field, which its mean shows too.
  static constexpr double most_falling = 0.15, straight = 0.8;
  static constexpr double most_outside = 0.25, most_out_of_range = 0.6;
  static constexpr double least_noise = 0.3;  // below this coherence, noise leaves no evidence
};

/// How well a band agrees with the band or cue that unwraps it, from SampleReading::relations.
struct BandRelation {
  /// |mean of exp(2 pi i r)| divided by its value under noise alone, measured between neighbours:
  /// 1 if r is the same everywhere, 0 if it is random.
  double agreement = 1;
  double offset = 0;  ///< of r, periods, -0.5 to 0.5
  double noise = 1;   ///< coherence under noise alone, 0 to 1
  double error = 0;   ///< standard error of the offset, periods

  /// Whether noise leaves no evidence.
  [[nodiscard]] bool is_hidden() const { return noise < FitLimits::least_noise; }
  /// Within the limits, or hidden.
  [[nodiscard]] bool agrees() const {
    return is_hidden() ||
           (agreement >= FitLimits::least_agreement && std::abs(offset) <= FitLimits::most_offset);
  }
};

/// Evidence about frames and sequence.
struct FrameEvidence {
  /// Part of the frames that the patterns' shapes cannot explain, as a share of their variation.
  /// Excludes noise: only what neighbours share counts.
  double residual = 0;
  std::vector<BandRelation> relations;  ///< coarse to fine
  /// Largest variation of a ratio of two bands' modulations from pixel to pixel: the standard
  /// deviation of its logarithm, without noise.
  double ratio_spread = 0;
  double doubt = 0;   ///< median: see SampleReading; 0 where noise alone leaves as much
  double origin = 0;  ///< error of the origin by single frames, rad
  /// Loss of the fringes' modulation against the cue's, as a share, if band and cue agree with it
  /// only.
  double damping = 0;
  /// Share of far pixel pairs across which the coordinate jumps from one end of the field to the
  /// other inside the lit area.
  double seams = 0;
  std::vector<CoordinateSample> coordinates{};  ///< of each group
};

/// Gathers evidence. Reuses its memory; not thread-safe.
class FrameJudge {
 public:
  /// Keeps a reference to the model.
  explicit FrameJudge(const FrameModel& model);

  /// Evaluates the samples, or their first `most_groups` groups (also spread over the picture),
  /// with the frames in that order. The result is valid until the next call.
  const FrameEvidence& operator()(const ScanSamples& samples, const FrameOrder& order,
                                  std::size_t most_groups = static_cast<std::size_t>(-1));

 private:
  /// Mean product over neighbours; independent noise cancels.
  struct SharedSpread {
    double products = 0, a = 0, b = 0;
    int count = 0;

    void add(double first, double second) {
      products += first * second;
      a += first;
      b += second;
      ++count;
    }

    [[nodiscard]] double deviation() const {
      if (count == 0) return 0;
      // Covariance of neighbours: their signal's variance, as noise is independent.
      return std::sqrt(std::max(0.0, products / count - a / count * (b / count)));
    }
  };

  void clear();
  /// Adds the neighbour on side 0, the right, or 1, below.
  void add_neighbour(const ScanSamples& samples, const FrameOrder& order, std::size_t group,
                     int side);
  void add_pair(int side, double variation);
  void sum_up(std::size_t groups);
  void look_for_damping(double groups);
  /// Logarithm of the ratio of a band's modulation to the coarsest band's.
  [[nodiscard]] double ratio(const SampleReading& reading, std::size_t band) const;

  const FrameModel& model_;
  FrameEvidence evidence_;
  SampleReading here_, next_;
  std::vector<std::complex<double>> mean_;  ///< of each relation
  /// Of each relation: the sums of its change to the right, and below.
  std::vector<std::array<std::complex<double>, 2>> between_;
  std::vector<std::complex<double>> damped_;  ///< of the cue's, for each damping
  std::vector<SharedSpread> ratios_;          ///< of each band
  std::vector<double> doubts_, misfits_;
  double residual_ = 0, variation_ = 0, by_origin_ = 0, origin_square_ = 0;
  int pairs_ = 0, seams_ = 0, far_pairs_ = 0;
};

/// Evidence compared with FitLimits.
struct Fit {
  /// Its residual is without the waveform's if that does no harm.
  FrameEvidence frames{};
  /// The waveform of frames that do not match the patterns, if it explains why.
  std::optional<Waveform> waveform{};
  CodeEvidence code{};
  bool moving = false;                         ///< CheckSettings::moving
  std::optional<GeometryEvidence> geometry{};  ///< nullopt without a scanner

  [[nodiscard]] bool has_evidence() const;  ///< of every relation, beyond noise

  /// Whether the bands agree in modulation.
  [[nodiscard]] bool bands_alike() const {
    return frames.ratio_spread <= FitLimits::most_ratio_spread;
  }
  [[nodiscard]] bool bands_agree() const;  ///< in phase and modulation
  /// The worst of the relations that do not agree; null without any.
  [[nodiscard]] const BandRelation* worst_relation() const;
  [[nodiscard]] bool patterns_made() const;  ///< the patterns explain the frames
  [[nodiscard]] bool code_agrees() const;    ///< within the limits of code_symptoms
  [[nodiscard]] bool no_seam() const { return frames.seams <= FitLimits::most_seams; }

  /// All that the frames alone show.
  [[nodiscard]] bool frames_fit() const {
    return bands_agree() && patterns_made() && code_agrees() && no_seam();
  }
  [[nodiscard]] bool geometry_fits() const;  ///< true without geometry

  /// In the calibrated range; true without geometry.
  [[nodiscard]] bool depths_fit() const {
    return !geometry || geometry->out_of_range <= FitLimits::most_out_of_range;
  }

  [[nodiscard]] bool all() const { return frames_fit() && geometry_fits() && depths_fit(); }
  /// Whether more points lie outside the projector's light, or nowhere, than in right scans.
  [[nodiscard]] bool has_stray_points() const;
  /// The share of a code's changes that may run backwards: noise turns those of unsure bits.
  [[nodiscard]] double most_falling() const;
  /// Whether it fits so poorly that another origin or frame order may fit far better.
  [[nodiscard]] bool poor() const;
  /// 0 for a perfect fit; of two explanations, the smaller misfit is likelier.
  [[nodiscard]] double misfit() const;
};

}  // namespace slipstream
