#pragma once

#include <cmath>

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

}  // namespace slipstream
