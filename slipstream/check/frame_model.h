#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "slipstream/check/scan_samples.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/decode/band_unwrapper.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Frames in the order in which they are taken for the patterns: frame `order[n]` for pattern n.
using FrameOrder = std::vector<int>;

/// What the frames of one pixel say.
struct SampleReading {
  std::vector<double> phase;       ///< of each band, rad, corrected for the response
  std::vector<double> modulation;  ///< of each band, grey levels of 255
  double coarse = 0;               ///< y by the cue, or by the band of fewest periods
  double coordinate = 0;           ///< y by all bands
  double across = 0;               ///< with a carrier: where along it, up to whole periods of it
  /// From few periods to many r = f y - phi / (2 pi), y by the bands before or by the cue: whole
  /// numbers but for noise where all is right.
  std::vector<double> relations;
  /// What no pattern of that shape makes, grey levels.
  std::vector<double> unexplained;
};

/// A sequence's patterns, as frames are compared with them.
class FrameModel {
 public:
  FrameModel(const Sequence& sequence, const PhotometricCalibration& photometry);

  [[nodiscard]] const Layout& layout() const { return layout_; }
  /// Indices of the bands that are compared, from few periods to many: with beats, likelihood or a
  /// code the measuring one alone.
  [[nodiscard]] const std::vector<std::size_t>& bands() const { return chain_; }
  [[nodiscard]] std::size_t measuring_band() const { return chain_.back(); }
  [[nodiscard]] double fewest_periods() const { return layout_.bands[chain_.front()].periods; }
  /// Whether frames give a coordinate with what is known.
  [[nodiscard]] bool has_coordinate() const {
    return has_real_cue() || alone_.has_value() || fewest_periods() <= 1;
  }
  /// Whether there is a cue that is a number of its own and no band, and can be read.
  [[nodiscard]] bool has_real_cue() const { return cue_.has_value(); }
  /// How many numbers the frames have more than patterns of that shape can give them.
  [[nodiscard]] std::size_t unexplained_count() const {
    return static_cast<std::size_t>(complement_.rows());
  }
  /// Whether frames can contradict each other: more of them than unknowns, or bands that must
  /// agree.
  [[nodiscard]] bool has_redundancy() const {
    return unexplained_count() > 0 || has_real_cue() || chain_.size() > 1;
  }
  [[nodiscard]] FrameOrder identity() const;

  /// `levels`: the intensities of the frames, as they are stored. Memory that the reading has is
  /// used again.
  void read(const float* levels, const FrameOrder& order, SampleReading& reading) const;

  /// How much of the range of pattern n the lit pixels see, 0 to 1.
  [[nodiscard]] double shown_range(int n, const ScanSamples& samples) const;

  /// How what is unexplained changes with the gain of frame n, from its intensity: a column.
  [[nodiscard]] Eigen::VectorXd unexplained_by(int n, double level) const {
    return level * complement_.col(n);
  }

 private:
  void unwrap(SampleReading& reading, double cue) const;
  [[nodiscard]] double coordinate_of(const SampleReading& reading, const float* levels,
                                     const FrameOrder& order) const;
  void explain(const float* levels, const FrameOrder& order, SampleReading& reading) const;
  /// Modulation and phase; of so many steps it is corrected for the response, 0: as it is.
  [[nodiscard]] std::pair<double, double> sinusoid(const float* levels, const FrameOrder& order,
                                                   const Band& band, int steps) const;
  [[nodiscard]] double shape(int n, const SampleReading& reading) const;
  [[nodiscard]] double light(int n, const SampleReading& reading) const;

  Sequence sequence_;
  Layout layout_;
  PhotometricCalibration photometry_;
  PhaseCorrections corrections_;
  std::vector<int> corrected_steps_;  ///< N of each band that is corrected, else 0
  std::vector<std::size_t> chain_;
  std::optional<CueEvidence> cue_;
  std::optional<BandUnwrapper> alone_;  ///< what gives the coordinate where the chain does not
  Eigen::MatrixXd complement_;          ///< rows: a basis of what no pattern of that shape makes
};

}  // namespace slipstream
