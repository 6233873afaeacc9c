#pragma once

#include <cmath>

#include "slipstream/layout.h"
#include "slipstream/maps.h"
#include "slipstream/pattern_set.h"

namespace slipstream {

/// What decoding a multiplexed cue requires in addition to the frames. Grey levels are those of an
/// 8-bit device, whatever the bits of the frames.
struct CueSettings {
  PatternLight light;           ///< of the displayed patterns
  double ambient = 0;           ///< beta of Eq. (3.2); used only for a cue in the DC channel
  double noise_variance = 1.6;  ///< sigma_w^2, > 0: weights a pixel's evidence
  CueRule rule = CueRule::consensus;
  double least_modulation = 0;  ///< B^c, >= 0: minimum for a pixel to vote
};

/// Throws Error for settings out of range.
void require_valid(const CueSettings& settings);

/// Values of one pixel in the frames of a layout that votes; grey levels of an 8-bit device.
struct CuePixel {
  double modulation = 0;     ///< B of the measuring band
  double wrapped_phase = 0;  ///< of the measuring band, rad, [0, 2 pi)
  double cue = 0;            ///< the cue's value, or C of the second band
  double cue_sine = 0;       ///< S of the second band
};

/// Parameters of CueEvidence::cost, grey levels of an 8-bit device.
struct CueCost {
  bool circle = false;
  CueReference reference{};   ///< R of a real cue
  double c1 = 1, c2 = 1;      ///< shares of the measuring band and of the cue
  double constant_light = 0;  ///< ambient light in the cue's channel
  double steady = 0;          ///< of the cue's slope over B, steady + c2 / c1 R(y)
  double component_variance = 1, cue_variance = 1;
};

/// Evidence of a pixel's frames for its fringe order. The cue alone gives a coordinate, Liu 2010,
/// Eqs. (3.58), (3.74), (3.88); all channels give the likelihood of any. A cue that is a second
/// band, of one period, is a circle: y = 0 and y = 1 coincide. A real cue is monotonic.
class CueEvidence {
 public:
  /// Requires a layout with Unwrapping::vote.
  CueEvidence(const Layout& layout, const CueSettings& settings);

  /// Whether the cue is a second band.
  [[nodiscard]] bool is_circle() const { return cost_.circle; }
  /// Largest modulation that may be noise: four standard deviations of C and S, 8-bit grey levels.
  [[nodiscard]] double dimmest_lit() const { return 4 * std::sqrt(cost_.component_variance); }
  /// Whether the modulation is above dimmest_lit() and at least settings.least_modulation.
  [[nodiscard]] bool lit(const CuePixel& pixel) const;

  /// Modulation, 8-bit grey levels, below which noise hides the fringe order even with neighbours:
  /// there the standard deviation of the cue, (3.67), (3.76), (3.101), is 0.6 of its change over a
  /// period. Ignores 15 % of the field at either end, where a cosine is flat.
  [[nodiscard]] double least_modulation() const;

  /// Projector coordinate from the cue alone, phi_u / (2 pi), in [0, 1].
  [[nodiscard]] double coordinate(const CuePixel& pixel) const;

  /// Distance of coordinate() from y, in periods of the high frequency, at most 0.5.
  [[nodiscard]] double doubt(const CuePixel& pixel, double y) const;

  [[nodiscard]] const CueCost& cost() const { return cost_; }

  /// Minus twice the log-likelihood of y, up to a constant per pixel; reflectivity is eliminated
  /// and each channel weighted by its noise, (3.14) and (3.27).
  [[nodiscard]] double cost(const CuePixel& pixel, double y) const;

  /// Contribution of a cue in the DC channel to the mean at y, grey levels; 0 for other cues.
  [[nodiscard]] double shade(const CuePixel& pixel, double y) const {
    return dc_ == 0 ? 0 : dc_ * pixel.modulation * cost_.c2 / cost_.c1 * cost_.reference(y);
  }

  /// The fringe order by the published rule: the nearest to coordinate(). If the cue is not a
  /// circle it is clamped to [0, f_h - 1].
  [[nodiscard]] int published_order(const CuePixel& pixel) const;

  /// Like published_order, but shifts a circle's order by whole turns until the coordinate lies in
  /// the field of a projector `projector_length` pixels long.
  [[nodiscard]] int nearest_order(const CuePixel& pixel, int projector_length) const;

  /// The most likely order near the field of a projector `projector_length` pixels long.
  [[nodiscard]] int likeliest_order(const CuePixel& pixel, int projector_length) const;

  /// Whether y lies in the field or at most margin() beyond its ends.
  [[nodiscard]] bool near_field(double y, int projector_length) const {
    const double past = margin(projector_length);
    return y >= -past && y <= 1 + past;
  }

  /// Half a pixel and a tenth of a period, so that noise at an end shifts no pixel by a period.
  [[nodiscard]] double margin(int projector_length) const {
    return 0.5 / projector_length + 0.1 / f_h_;
  }

 private:
  /// The cue's channel without ambient light, over B, at y: (3.56) / (3.57) and (3.73) / (3.72).
  [[nodiscard]] double slope(double y) const {
    return cost_.steady + cost_.c2 / cost_.c1 * cost_.reference(y);
  }

  CueSettings settings_;
  CueCost cost_;
  double f_h_;
  double dc_ = 0;  ///< Cue::dc
};

}  // namespace slipstream
