#pragma once

#include <limits>
#include <optional>

#include "slipstream/capture/frame_set.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/phase/fringe_order_consensus.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {

/// What decides whether a pixel becomes a point, and how it is computed.
struct ReconstructSettings {
  Backend backend = Backend::lut;
  /// Least modulation B^c, grey levels of the frames; by default 15 of an 8-bit camera's 255 and as
  /// much of another's full scale.
  std::optional<double> minimum_modulation;
  /// A pixel with a saturated frame is dropped (`false` keeps it, biased).
  bool drop_saturated = true;
  /// When the fringe order of a strategy with several frequencies is believed.
  FringeOrderConsensus fringe_order;
  /// Of a strategy whose fringe order comes from a cue in the same frames: the light of its
  /// patterns and of the room, and the rule by which it is unwrapped.
  CueSettings cue;
  /// What is added to each sinusoid's phase, by its N, so that the projector's response does not
  /// show; none where empty. Costs no time where phase is looked up.
  PhaseCorrections phase_corrections;
  /// How far past the ends of the projector's field, as a share of its length across the stripes, a
  /// point may lie.
  double field_margin = 0.02;
  double nearest = 0;                                         ///< mm, least depth
  double farthest = std::numeric_limits<double>::infinity();  ///< mm, largest depth
};

/// A scan in 3-D, with what it was made from.
struct Reconstruction {
  Cloud cloud;
  DecodedScan decoded;
};

/// Frames to cloud, for one scanner, strategy and axis; tables are built once.
class Reconstructor {
 public:
  /// Throws Error where the scanner or the settings are not valid, or the strategy's frames do not
  /// give a projector coordinate.
  Reconstructor(const Scanner& scanner, const Strategy& strategy, Axis axis,
                const ReconstructSettings& settings = {});

  /// Throws Error when the frames are not of the camera's size or not as many as the strategy's.
  [[nodiscard]] Reconstruction operator()(const FrameSet& frames) const;

  /// How sure each point of a scan is under noise of settings.cue.noise_variance on each frame:
  /// sigma of y by Eq. (3.40) or (3.63), and of X, Y, Z through the derivative of the point.
  /// `frames` are those that the scan was made from.
  [[nodiscard]] Uncertainty uncertainty(const Reconstruction& scan, const FrameSet& frames) const;

  [[nodiscard]] const Decoder& decoder() const { return decode_; }

 private:
  /// Why a pixel is left out before it is triangulated, and `valid` where it is not.
  [[nodiscard]] Image<Validity> measured(const DecodedScan& decoded, const FrameSet& frames) const;
  [[nodiscard]] Cloud triangulated(const DecodedScan& decoded, Image<Validity> validity) const;
  [[nodiscard]] Validity validity_of(const Eigen::Vector3d& point) const;

  ReconstructSettings settings_;
  Axis axis_;
  Strategy strategy_;
  double highest_frequency_;
  Triangulator triangulate_;
  Decoder decode_;
};

}  // namespace slipstream
