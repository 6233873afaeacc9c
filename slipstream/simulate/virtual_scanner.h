#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

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
  /// Pixels by which a place as far again as the working distance is blurred besides; in between in
  /// proportion, the two added in squares.
  double defocus = 0;

  /// Pixels, at `distance` times the working distance.
  [[nodiscard]] double at(double distance) const {
    return std::hypot(blur, defocus * (distance - 1));
  }
  friend bool operator==(const Sharpness&, const Sharpness&) = default;
};

/// What makes a real rig differ from the equations. Every effect that is 0 or false is not there;
/// by default none is.
struct Physics {
  /// Light is even over each pixel of the projector, and one of 256 levels.
  bool projector_pixels = false;
  Sharpness projector{}, camera{};
  double vignetting = 0;  ///< share of the light that either lens loses in its corners
  /// The projector's light falls with the distance squared; what it is half way to the near end of
  /// the working volume it would be everywhere without.
  bool fall_off = false;
  double gloss = 0;         ///< added to every body's
  double translucency = 0;  ///< mm that a half of the light spreads within a surface
  /// Rays of a pixel that look for light which other surfaces throw on what it sees; one bounce.
  int bounces = 0;
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

/// Light and sensor of the virtual scanner. Intensities are in grey levels of an 8-bit device
/// whatever the bits: full scale is 255.
struct Photometry {
  double ambient = 0;   ///< beta of Liu 2010, Eq. (3.2); may be negative, as a camera's offset
  Response response{};  ///< of the projected intensity / 255, Eq. (4.2); gamma 0.1 to 20
  double noise_variance = 0;  ///< sigma_w^2, Gaussian, grey levels^2
  /// Bits of the camera, 8 to 16: intensities are rounded and clipped. None: neither.
  std::optional<int> bits = 8;
  std::uint64_t seed = 1;  ///< of the noise; the same seed gives the same frames
  /// Rays of a pixel, 1 to 256: it sees the mean of what they meet. One goes through its centre;
  /// more are spread over it where surface, light or reflectivity are not even, so that an edge
  /// lies where it is to about 1 / rays of a pixel.
  int rays = 1;
  Physics physics{};
};

/// What a virtual camera saw, and what was really there half way from the first to the last
/// moment of its exposures; `look` tells what was there at any other time.
struct VirtualScan {
  FrameSet frames;
  Image<double> depth;  ///< Z of the surface in the camera's frame, mm; NaN where there is none
  /// y that lights it, [0, 1) but for half a pixel at either end; NaN in shadow or outside the
  /// field.
  Image<double> coordinate;
  Image<double> reflectivity;  ///< alpha, shading and gloss included; 0 where there is no surface
  std::shared_ptr<const SeenScene> seen{};  ///< when the first frame was taken
  Size projector{};
  bool in_colour = false;  ///< three frames are the channels of one picture
  FrameSet white{};        ///< in colour: the channels of a picture under an even grey
};

/// Takes the frames of `patterns` with a camera and a projector as `scanner` says, one ray for each
/// pixel's centre or as many as the photometry says: I = alpha (I^p + beta) + beta + w, Eq. (3.2),
/// I^p = 0 in the projector's shadow and outside its field; the light is as many times as
/// much as the pattern's exposure says. Unless the photometry's physics say otherwise patterns are
/// exact: not sampled by projector pixels nor quantised; binary ones are their pictures. Throws
/// Error where the scanner or the photometry is not valid. The first frame is taken at `time`, the
/// others one frame later each.
VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry = {}, double time = 0);

/// The frames of other patterns, or with other light, from where `scan` was taken: of the scene as
/// it stood then, without tracing its rays again. Rays, blur and bounces are those of the
/// first time. Throws Error where the photometry is not valid.
FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry);

/// Throws Error, naming what is out of range.
void require_valid(const Photometry& photometry);

/// A projector and a camera in colour, and surfaces that are painted.
struct ColourDevices {
  ColourMixture mixture{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  ///< its dark levels are 0
  /// How much of each channel's light paint takes at most, 0 to 1: its hue goes round every 40 mm
  /// of the surface. 0: all is grey.
  double paint = 0;
};

/// What such devices see of a mixture of 20 % and channels of unlike gain.
inline constexpr ColourMixture usual_mixture{
    {{1, 0.2, 0.05, 0}, {0.15, 0.9, 0.2, 0}, {0.05, 0.2, 0.75, 0}}};

/// As take_scan, but three patterns are shown at once, each picture's channels are three frames,
/// and there is a white picture. Throws Error where the patterns are not a multiple of three, the
/// scene moves or the paint is out of range.
VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices);

}  // namespace slipstream
