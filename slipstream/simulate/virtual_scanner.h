#pragma once

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"

namespace slipstream {

/// How sharp a device's picture is.
struct Sharpness {
  double blur = 0;  ///< standard deviation of its Gaussian at the working distance, pixels
  /// Added in squares, pixels, at twice the working distance; elsewhere in proportion.
  double defocus = 0;

  /// Pixels, at `distance` times the working distance.
  [[nodiscard]] double at(double distance) const {
    return std::hypot(blur, defocus * (distance - 1));
  }
  friend bool operator==(const Sharpness&, const Sharpness&) = default;
};

/// What makes a real rig differ from the equations; every effect is off by default.
struct Physics {
  bool projector_pixels = false;  ///< light is even over each, and one of 256 levels
  Sharpness projector{}, camera{};
  double vignetting = 0;  ///< share of the light that either lens loses in its corners
  /// Light falls with the distance squared, from what patterns say half way to the near end of the
  /// working volume.
  bool fall_off = false;
  double gloss = 0;         ///< added to every body's
  double translucency = 0;  ///< mm that a half of the light spreads within a surface
  int bounces = 0;          ///< rays of a pixel that look for light from other surfaces; one bounce
  double ambient_gradient = 0;  ///< share by which ambient light rises from the middle to the right
  double flicker = 0;           ///< share by which all light differs from frame to frame
  bool motion_blur = false;     ///< bodies move on while a frame is exposed, for half of its time
  bool rolling_shutter = false;  ///< the last row is exposed almost a frame after the first
  double lens_residue = 0;       ///< camera pixels by which no lens model fits, at most
  // The sensor, by the model of EMVA 1288.
  double full_well = 0;           ///< electrons at full scale, whose number is random: shot noise
  double read_noise = 0;          ///< standard deviation, electrons; needs the full well
  double row_noise = 0;           ///< of what a row's pixels have in common in a frame, grey levels
  double dark_spread = 0;         ///< of the pixels' offsets, the same in all frames, grey levels
  double sensitivity_spread = 0;  ///< of the pixels' sensitivities, a share
  // Calibration boards.
  double board_bend = 0;     ///< mm by which the middle of a board stands out
  double board_stretch = 0;  ///< share by which it is printed too large along its rows

  friend bool operator==(const Physics&, const Physics&) = default;
};

struct SeenScene;

/// Light and sensor of the virtual scanner. Full scale is a grey level of 255 whatever the bits.
struct Photometry {
  double ambient = 0;   ///< beta of Liu 2010, Eq. (3.2); may be negative, as a camera's offset
  Response response{};  ///< of the projected intensity / 255, Eq. (4.2); gamma 0.1 to 20
  double noise_variance = 0;    ///< sigma_w^2, Gaussian, grey levels^2
  std::optional<int> bits = 8;  ///< of the camera, 8 to 16; none: not rounded and not clipped
  std::uint64_t seed = 1;       ///< of the noise; the same seed gives the same frames
  /// Rays of a pixel, 1 to 256, which sees their mean: one through its centre, or where surface,
  /// light or reflectivity are not even several, so that an edge is right to 1 / rays of a pixel.
  int rays = 1;
  Physics physics{};
};

/// What a virtual camera saw, and what was there half way through its exposures.
struct VirtualScan {
  FrameSet frames;
  Image<double> depth;  ///< Z of the surface in the camera's frame, mm; NaN where there is none
  /// y that lights it, [0, 1) give or take half a pixel; NaN in shadow or outside the field.
  Image<double> coordinate;
  Image<double> reflectivity;  ///< alpha, shading and gloss included; 0 where there is no surface
  std::shared_ptr<const SeenScene> seen{};  ///< when the first frame was taken
  Size projector{};
  bool in_colour = false;  ///< three frames are the channels of one picture
  FrameSet white{};        ///< in colour: the channels of a picture under an even grey
};

/// Takes the frames of `patterns`, the first at `time`, the others one frame later each: I = alpha
/// (I^p + beta) + beta + w, Eq. (3.2), I^p times the pattern's exposure, and 0 in the projector's
/// shadow and outside its field. Unless physics say otherwise patterns are exact, neither sampled
/// by projector pixels nor quantised; binary ones are their pictures. Throws Error where the
/// scanner or the photometry is not valid.
VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry = {}, double time = 0);

/// The frames of other patterns, or with other light, of the scene as it stood when `scan` was
/// taken. No rays are traced again: their number, blur and bounces stay. Throws Error where the
/// photometry is not valid.
FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry);

/// Throws Error, naming what is out of range.
void require_valid(const Photometry& photometry);

/// A projector and a camera in colour, and surfaces that are painted.
struct ColourDevices {
  ColourMixture mixture{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  ///< its dark levels are 0
  double paint =
      0;  ///< most that paint takes of a channel's light, 0 to 1; its hues repeat in 40 mm
};

/// A mixture of 20 % and channels of unlike gain.
inline constexpr ColourMixture usual_mixture{
    {{1, 0.2, 0.05, 0}, {0.15, 0.9, 0.2, 0}, {0.05, 0.2, 0.75, 0}}};

/// As take_scan, but three patterns are shown at once, each picture gives three frames, and there
/// is a white picture. Throws Error unless the patterns are a multiple of three, the scene stands
/// still and the paint is in range.
VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices);

}  // namespace slipstream
