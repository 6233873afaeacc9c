#pragma once

#include <cmath>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// How the fringe order is found from a cue that shares the frames with the high frequency.
enum class CueRule {
  published,   ///< Liu 2010, Section 3.2: the cue's coordinate, solved for, names the nearest order
  likelihood,  ///< the order under which all channels of the pixel together are likeliest
  consensus,   ///< the likeliest order of the pixel and of its neighbours on the same surface
};

/// "published", "likelihood", "consensus".
std::string_view name_of(CueRule rule);

/// The rule of that name; throws Error for any other.
CueRule cue_rule_named(std::string_view name);

/// What a decoder must know, beside the frames, of a cue multiplexed into the patterns. Grey levels
/// are those of an 8-bit device, whatever the bits of the frames.
struct CueSettings {
  PatternLight light;           ///< of the patterns that were shown
  double ambient = 0;           ///< beta of Eq. (3.2); only a cue in the DC channel needs it
  double noise_variance = 1.6;  ///< sigma_w^2, > 0: how much the evidence of a pixel is worth
  CueRule rule = CueRule::consensus;
  double least_modulation = 0;  ///< B^c, >= 0: a darker pixel has no say in its neighbours' orders
};

/// Throws Error for settings outside their ranges.
void require_valid(const CueSettings& settings);

/// What the frames of a layout that votes say about one pixel; grey levels of an 8-bit device.
struct CuePixel {
  double modulation = 0;     ///< B of the measuring band
  double wrapped_phase = 0;  ///< of it, rad, [0, 2 pi)
  double cue = 0;            ///< the cue's number, or C of the second band
  double cue_sine = 0;       ///< S of the second band
};

/// The numbers in CueEvidence::cost, grey levels of an 8-bit device.
struct CueCost {
  bool circle = false;
  CueReference reference{};   ///< R of a real cue
  double c1 = 1, c2 = 1;      ///< shares of the measuring band and of the cue
  double constant_light = 0;  ///< what the ambient light adds to the cue's channel
  double steady = 0;          ///< of the cue's slope over B, which is steady + c2 / c1 R(y)
  double component_variance = 1, cue_variance = 1;
};

/// What the frames of a pixel say about its fringe order. The cue alone gives a coordinate, Liu
/// 2010, Eqs. (3.58), (3.74), (3.88); all channels give the likelihood of any. A cue that is a
/// second band, of one period, is a circle: y = 0 and y = 1 are one place. A real cue is monotonic.
class CueEvidence {
 public:
  /// Of a layout with Unwrapping::vote.
  CueEvidence(const Layout& layout, const CueSettings& settings);

  /// Whether the cue is a second band.
  [[nodiscard]] bool is_circle() const { return cost_.circle; }
  /// Largest modulation that may be noise: four standard deviations of C and S, 8-bit grey levels.
  [[nodiscard]] double dimmest_lit() const { return 4 * std::sqrt(cost_.component_variance); }
  /// Whether the modulation is above dimmest_lit() and not below the settings' least.
  [[nodiscard]] bool lit(const CuePixel& pixel) const;

  /// The modulation, 8-bit grey levels, below which noise hides the fringe order even from
  /// neighbours: there the standard deviation of the cue, (3.67), (3.76), (3.101), is 0.6 of its
  /// change over a period, 15 % of the field at either end, where a cosine is flat, left out.
  [[nodiscard]] double least_modulation() const;

  /// The projector coordinate that the cue alone gives, phi_u / (2 pi), in [0, 1].
  [[nodiscard]] double coordinate(const CuePixel& pixel) const;

  /// How far coordinate() lies from y, in periods of the high frequency, at most 0.5.
  [[nodiscard]] double doubt(const CuePixel& pixel, double y) const;

  [[nodiscard]] const CueCost& cost() const { return cost_; }

  /// Minus twice the logarithm of the likelihood of y, up to a constant of the pixel; reflectivity
  /// eliminated, each channel weighed by its noise, (3.14) and (3.27).
  [[nodiscard]] double cost(const CuePixel& pixel, double y) const;

  /// What a cue in the DC channel adds to the mean at y, grey levels; 0 for others.
  [[nodiscard]] double shade(const CuePixel& pixel, double y) const {
    return dc_ == 0 ? 0 : dc_ * pixel.modulation * cost_.c2 / cost_.c1 * cost_.reference(y);
  }

  /// The fringe order by the published rule: the nearest to coordinate(). Where the cue is not a
  /// circle it is held to [0, f_h - 1].
  [[nodiscard]] int published_order(const CuePixel& pixel) const;

  /// The same, except that a circle's order is moved by whole turns until the coordinate lies in
  /// the field of a projector `projector_length` pixels long.
  [[nodiscard]] int nearest_order(const CuePixel& pixel, int projector_length) const;

  /// The likeliest order among those near the field of a projector `projector_length` pixels long.
  [[nodiscard]] int likeliest_order(const CuePixel& pixel, int projector_length) const;

  /// Whether y lies in the field or at most margin() past its ends.
  [[nodiscard]] bool near_field(double y, int projector_length) const {
    const double past = margin(projector_length);
    return y >= -past && y <= 1 + past;
  }
  /// Half a pixel and a tenth of a period, lest noise at an end carry a pixel a period on.
  [[nodiscard]] double margin(int projector_length) const {
    return 0.5 / projector_length + 0.1 / f_h_;
  }

 private:
  /// The cue's channel less ambient light, over B, at y: (3.56) / (3.57) and (3.73) / (3.72).
  [[nodiscard]] double slope(double y) const {
    return cost_.steady + cost_.c2 / cost_.c1 * cost_.reference(y);
  }

  CueSettings settings_;
  CueCost cost_;
  double f_h_;
  double dc_ = 0;  ///< Cue::dc
};

}  // namespace slipstream
