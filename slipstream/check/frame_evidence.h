#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slipstream/check/scan_samples.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/phase/phase_correction.h"
#include "slipstream/strategy/sequence.h"
#include "slipstream/unwrap/cue_evidence.h"

namespace slipstream {

/// Frames in the order in which they are taken for the patterns: frame `order[n]` for pattern n.
using FrameOrder = std::vector<int>;

/// How a band goes with what it is unwrapped by: r = f y - phi / (2 pi), y by the band before it or
/// by the cue. Where all is right r is a whole number but for noise.
struct BandRelation {
  /// Length of the mean of exp(2 pi i r) over that which noise leaves of it, measured between
  /// neighbours; 1 where r is the same all over, 0 where it is anything.
  double agreement = 1;
  double offset = 0;  ///< of r, periods, -0.5 to 0.5
  double noise = 1;   ///< what noise leaves, 0 to 1; below 0.3 nothing is to be told
};

/// What the samples say about frames and sequence.
struct FrameEvidence {
  std::size_t groups = 0;
  /// How far the frames are from what patterns of that shape can make, as a share of their
  /// variation. Noise is not in it: only what neighbours share is counted.
  double residual = 0;
  std::vector<BandRelation> relations;  ///< from few periods to many
  /// Median of each band's modulation over that of the band of fewest periods, their shares in the
  /// patterns taken out.
  std::vector<double> modulation_ratios;
  double ratio_spread = 0;  ///< standard deviation of its logarithm, without noise; the largest
  bool ordered = true;      ///< bands of more periods vary more from pixel to pixel
  /// Where the coordinate leaps from one end of the field to the other in the middle of the light.
  double seams = 0;  ///< share of the pairs of far pixels that could show one
};

/// What one place of a group says.
struct SampleDecode {
  double coordinate = 0;  ///< y by all bands
  double phase = 0;       ///< of the measuring band, rad
  /// What a sinusoid of all the light would have, grey levels of 255: the least of the bands.
  double modulation = 0;
};

/// A sequence's patterns, as samples are compared with them.
class FrameModel {
 public:
  FrameModel(const Sequence& sequence, const PhotometricCalibration& photometry);

  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] FrameOrder identity() const;
  /// Whether frames can contradict each other: more of them than unknowns, or bands that must
  /// agree.
  [[nodiscard]] bool has_redundancy() const {
    return complement_.rows() > 0 || cue_ || chain_.size() > 1;
  }

  [[nodiscard]] FrameEvidence evidence(const ScanSamples& samples, const FrameOrder& order) const;
  [[nodiscard]] FrameEvidence evidence(const ScanSamples& samples) const {
    return evidence(samples, identity());
  }

  [[nodiscard]] SampleDecode decode(const ScanSamples& samples, std::size_t group,
                                    ScanSamples::Place place, const FrameOrder& order) const;

  /// How much brighter each frame is than the others, as a share, from what patterns of that shape
  /// cannot make; their mean is 0. `explained`: the share of the residual that it accounts for.
  struct Gains {
    std::vector<double> gains;
    double explained = 0;
  };
  [[nodiscard]] Gains gains(const ScanSamples& samples) const;

  /// The number of periods of the band `relation` with which it agrees best with the one before it,
  /// and how well; none where no number is clearly better than the others.
  [[nodiscard]] std::optional<double> periods_that_agree(const ScanSamples& samples,
                                                         std::size_t relation,
                                                         const FrameOrder& order) const;

 private:
  /// Bands and cue at one pixel.
  struct Reading;

  void read(const float* levels, const FrameOrder& order, Reading& reading) const;
  /// r of each relation, into `phases`, periods.
  void relate(const Reading& reading, std::vector<double>& r) const;
  [[nodiscard]] double coarse_coordinate(const Reading& reading) const;
  /// What patterns of that shape cannot make, of a pixel's frames.
  [[nodiscard]] Eigen::VectorXd unexplained(const float* levels, const FrameOrder& order,
                                            const Reading& reading) const;
  [[nodiscard]] double measured_coordinate(const Reading& reading) const;

  Sequence sequence_;
  Layout layout_;
  PhotometricCalibration photometry_;
  PhaseCorrections corrections_;
  std::vector<int> correction_steps_;  ///< N of each band that is corrected, else 0
  std::vector<std::size_t> chain_;     ///< bands from few periods to many
  std::optional<CueEvidence> cue_;     ///< real, where there is one
  Eigen::MatrixXd complement_;         ///< rows: what no pattern of that shape makes
};

}  // namespace slipstream
