#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "check/scan_samples.h"
#include "decode/band_unwrapper.h"
#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Assignment of frames to patterns: frame `order[n]` shows pattern n.
using FrameOrder = std::vector<int>;

/// The measurements of one pixel's frames.
struct SampleReading {
  std::vector<double> phase;       ///< of each band, rad, corrected for the response
  std::vector<double> modulation;  ///< of each band, grey levels of 255
  /// With a response: the light of each pattern there, 0 to 1, and the bands' modulations by it,
  /// otherwise 1.
  std::vector<float> made;
  std::vector<double> expected;
  double coarse = 0;      ///< y from the cue, or from the coarsest band
  double coordinate = 0;  ///< y from all bands
  double across = 0;      ///< position along the carrier, if any, modulo its period
  /// Coarse to fine: r = f y - phi / (2 pi), with y from the coarser bands or the cue. Whole
  /// numbers, apart from noise, if all is right.
  std::vector<double> relations;
  /// Components that the patterns' shapes cannot explain, grey levels.
  std::vector<double> unexplained;
  double doubt = 0;  ///< of the coordinate if no band unwraps another: see PixelCoordinate
  /// With single frames: mean square of the frames' rest after the fit, over the noise variance;
  /// infinite if it is unknown.
  double misfit = std::numeric_limits<double>::infinity();
  /// With single frames, or bands that are unwrapped together: products r.d and d.d of the residual
  /// r and its derivative d by the origin. The ratio of their sums is the error of the origin, rad.
  double by_origin = 0, origin_square = 0;
};

/// Model of a sequence's patterns, for comparison with frames.
class FrameModel {
 public:
  /// `same_light`: a model with the same photometry and light, whose corrections are taken over.
  FrameModel(const Sequence& sequence, const PhotometricCalibration& photometry,
             const FrameModel* same_light = nullptr);

  [[nodiscard]] const Layout& layout() const { return layout_; }

  /// Indices of the compared bands, coarse to fine. With beats, likelihood or a code: only the
  /// measuring band.
  [[nodiscard]] const std::vector<std::size_t>& bands() const { return chain_; }
  [[nodiscard]] std::size_t measuring_band() const { return chain_.back(); }
  [[nodiscard]] double fewest_periods() const { return layout_.bands[chain_.front()].periods; }

  /// Whether the frames determine a coordinate.
  [[nodiscard]] bool has_coordinate() const {
    return has_real_cue() || alone_.has_value() || fewest_periods() <= 1;
  }

  /// Whether a readable cue exists that is a separate value, not a band.
  [[nodiscard]] bool has_real_cue() const { return cue_.has_value(); }
  /// Number of independent combinations of the frames that are 0 for these pattern shapes.
  [[nodiscard]] std::size_t unexplained_count() const { return complement_.rows(); }

  /// Whether frames can contradict each other: there are more of them than unknowns, or bands that
  /// must agree.
  [[nodiscard]] bool has_redundancy() const {
    return unexplained_count() > 0 || has_real_cue() || chain_.size() > 1;
  }

  [[nodiscard]] const FrameOrder& identity() const { return identity_; }

  /// y where a stripe of the code begins: between its first pixel and the last of the one before.
  /// Exactly there if the projector's size is unknown.
  [[nodiscard]] double edge_of_stripe(int stripe) const;

  /// `levels`: the intensities of the frames, in stored order. Reuses the memory of `reading`.
  void read(const float* levels, const FrameOrder& order, SampleReading& reading) const;

  /// The components of these frames, a column for each pixel, that no pattern explains.
  [[nodiscard]] Eigen::MatrixXd unexplained_of(const Eigen::MatrixXd& frames) const {
    return complement_ * frames;
  }

  /// SampleReading::coarse alone, faster than read(); only for models without a cue.
  [[nodiscard]] double coarse(const float* levels, const FrameOrder& order) const;

  /// Projection of a pixel's frames, in order, that removes its mean, its modulation and a small
  /// change of the coordinate.
  [[nodiscard]] Eigen::MatrixXd unexplained_at(const SampleReading& reading) const;

  /// Derivative of the unexplained components by the gain of frame n, from its intensity: a column.
  [[nodiscard]] Eigen::VectorXd unexplained_by(int n, double level) const {
    return level * complement_.col(n);
  }

 private:
  /// Takes over the corrections for a response, or computes them.
  void correct_for(const Response& response, const FrameModel* same_light);
  void unwrap(SampleReading& reading, double cue) const;
  /// From single frames, and from bands that are unwrapped together.
  void fit_origin(const float* levels, const FrameOrder& order, SampleReading& reading) const;
  void fit_origin(SampleReading& reading) const;
  void explain(const float* levels, const FrameOrder& order, SampleReading& reading) const;
  /// Modulation and phase, corrected for the response as these steps need it; not corrected if
  /// there are 0.
  [[nodiscard]] std::pair<double, double> sinusoid(const float* levels, const FrameOrder& order,
                                                   const Band& band, const StepRun& steps) const;
  /// Modulation and phase of a band, without its carrier.
  [[nodiscard]] std::pair<double, double> demodulated(const float* levels, const FrameOrder& order,
                                                      std::size_t band) const;
  [[nodiscard]] double shape(int n, const SampleReading& reading) const;
  /// Light of pattern n at the reading's coordinate, 0 to 1: its shape, through the response if
  /// that is known.
  [[nodiscard]] double light(int n, const SampleReading& reading) const;

  Sequence sequence_;
  Layout layout_;
  PhotometricCalibration photometry_;
  PhaseCorrections corrections_;
  /// Of each band: the steps that its phases are corrected for, 0 if they are not; then those of
  /// its mirrored sinusoids.
  std::vector<std::vector<StepRun>> corrected_;
  std::vector<std::size_t> chain_;
  std::optional<CueEvidence> cue_;
  std::optional<BandUnwrapper> alone_;  ///< gives the coordinate if the chain does not
  FrameOrder identity_;
  Eigen::MatrixXd complement_;  ///< rows: orthogonal to all pattern shapes
  std::vector<double> light_;   ///< with a response: of shapes from 0 to 1, and once more
};

/// Applies `first` (identity if empty), then `then`, as one order.
FrameOrder composed(const FrameOrder& first, const FrameOrder& then);

/// "2,0,1,3,4,5".
std::string text_of(const FrameOrder& order);

}  // namespace slipstream
