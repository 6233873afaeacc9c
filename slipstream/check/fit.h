#pragma once

#include <complex>

#include "slipstream/check/frame_model.h"

namespace slipstream {

/// How a band goes with what it is unwrapped by, from SampleReading::relations.
struct BandRelation {
  /// Length of the mean of exp(2 pi i r) over that which noise leaves of it, measured between
  /// neighbours; 1 where r is the same all over, 0 where it is anything.
  double agreement = 1;
  double offset = 0;  ///< of r, periods, -0.5 to 0.5
  double noise = 1;   ///< what noise leaves, 0 to 1
};

/// What the samples say about frames and sequence.
struct FrameEvidence {
  /// How far the frames are from what patterns of that shape can make, as a share of their
  /// variation. Noise is not in it: only what neighbours share is counted.
  double residual = 0;
  std::vector<BandRelation> relations;  ///< from few periods to many
  /// How much the bands' modulations differ from pixel to pixel, over each other: the standard
  /// deviation of the logarithm, without noise; the largest.
  double ratio_spread = 0;
  /// Where the coordinate leaps from one end of the field to the other in the middle of the light:
  /// share of the pairs of far pixels that could show it.
  double seams = 0;
};

/// Gathers evidence; its memory is used again. One thread uses it.
class FrameJudge {
 public:
  /// Refers to the model.
  explicit FrameJudge(const FrameModel& model);

  /// Of the samples, or of the first so many groups, which are spread over the picture too, with
  /// the frames in that order. Valid until the next call.
  const FrameEvidence& operator()(const ScanSamples& samples, const FrameOrder& order,
                                  std::size_t most_groups = static_cast<std::size_t>(-1));

 private:
  /// Mean of a product over neighbours, without the noise that they do not share.
  struct SharedSpread {
    double products = 0, a = 0, b = 0;
    int count = 0;

    void add(double first, double second);
    [[nodiscard]] double deviation() const;
  };

  void clear();
  void add_pair(double variation);
  void add_far_pair();
  void sum_up(std::size_t groups);
  /// Logarithm of a band's modulation over that of the band of fewest periods.
  [[nodiscard]] double ratio(const SampleReading& reading, std::size_t band) const;

  const FrameModel& model_;
  FrameEvidence evidence_;
  SampleReading here_, next_;
  std::vector<std::complex<double>> mean_, between_;  ///< of each relation
  std::vector<SharedSpread> ratios_;                  ///< of each band
  double residual_ = 0, variation_ = 0;
  int pairs_ = 0, seams_ = 0, far_pairs_ = 0;
};

/// The number of periods with which the band of that relation agrees best with what it is unwrapped
/// by; none where no number agrees.
std::optional<double> periods_that_agree(const FrameModel& model, const ScanSamples& samples,
                                         std::size_t relation);

/// What the samples say about frames and scanner.
struct GeometryEvidence {
  double without_point = 0;  ///< share whose ray meets its stripe nowhere in front of both devices
  double outside = 0;        ///< share of points where the projector sends no light
  double median_depth = 0;   ///< mm
  double out_of_range = 0;   ///< share of points outside of the calibrated depths, with a margin
  /// Median over the pixels of how much the coordinate changes from one pixel to the next, over how
  /// much it would on a surface that faces the camera: about 1 where all is right, negative where
  /// the stripes run the other way, near 0 where they run along the other axis. 1
  /// of a code alone.
  double slope = 1;
  double slope_doubt = 0;  ///< three standard errors of it, by how much the pixels scatter
};

/// Pictures that were turned over before they were saved.
struct PictureTurn {
  bool columns = false;  ///< the right side is on the left
  bool rows = false;     ///< the top is at the bottom
};

/// Lens distortion of the projector is left out: it moves points by less than what is asked here.
GeometryEvidence geometry_evidence(const FrameModel& model, const ScanSamples& samples,
                                   const Scanner& scanner, Axis axis, const FrameOrder& order,
                                   const PictureTurn& turn = {});

/// Whether evidence is that of a right scan. The limits lie between what right scans show, real and
/// virtual ones with noise, and what mistakes do: tests/check shows both.
struct Fit {
  FrameEvidence frames{};
  bool moving = false;                         ///< CheckSettings::moving
  std::optional<GeometryEvidence> geometry{};  ///< where a scanner is known

  [[nodiscard]] bool bands_alike() const;    ///< about modulation
  [[nodiscard]] bool bands_agree() const;    ///< about phase and modulation, and in their order
  [[nodiscard]] bool patterns_made() const;  ///< frames are what such patterns make
  [[nodiscard]] bool no_seam() const;
  [[nodiscard]] bool geometry_fits() const;  ///< true where there is none
  [[nodiscard]] bool depths_fit() const;     ///< in the calibrated range; true where there is none
  [[nodiscard]] bool all() const {
    return bands_agree() && patterns_made() && no_seam() && geometry_fits() && depths_fit();
  }
  /// 0 for what could not be better; of two explanations the lesser is the likelier.
  [[nodiscard]] double misfit() const;
};

}  // namespace slipstream
