#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/physics.h"
#include "slipstream/simulate/scene.h"

namespace slipstream {

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

}  // namespace slipstream
