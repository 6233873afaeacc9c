#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// Light that reaches a camera pixel from a place of the projector's picture.
struct LitSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the projector
  double strength = 0;  ///< of the projector's light: reflectivity, fall-off, share of the pixel
  double blur = 0;      ///< standard deviation of the projector's Gaussian there, its pixels
  double spread = 0;    ///< of half of the light within the surface, likewise
};

/// What the camera's pixels see of a scene as it stands at one time: all that frames of any
/// patterns, with any noise, are made of.
struct SeenScene {
  explicit SeenScene(Size size);

  Image<double> depth;         ///< at the pixels' centres, mm; NaN where there is no surface
  Image<double> reflectivity;  ///< alpha there, shading and gloss included; 0: no surface
  Image<double> albedo;        ///< mean alpha of a pixel, for ambient light
  Image<double> blur;          ///< standard deviation of the camera's Gaussian, pixels
  /// The projector's pixel that lights a pixel's centre; NaN in shadow and outside the field.
  Image<double> lit_column;
  Image<double> lit_row;
  std::vector<std::vector<LitSample>> samples;  ///< of each row's pixels, one after the other
  Image<int> sample_count;                      ///< how many of them are a pixel's
};

/// `time`: in frames, 0 at the first; of the first row where the shutter rolls. Where the surface
/// is even a pixel sees what its centre does; at edges it is the mean of as many rays as the
/// photometry says.
SeenScene look(const Scanner& scanner, const Scene& scene, const Photometry& photometry,
               double time);

/// Grey levels of 8 bits that a place of the projector's picture sends out under some blur.
using ProjectedLight = std::function<double(const LitSample&)>;

/// What the pixels collect in frame n, grey levels of 8 bits, before the sensor's noise: I =
/// alpha (I^p + beta) + beta, Eq. (3.2), with what physics adds, `exposure` times as long as usual.
Image<double> exposed(const SeenScene& seen, const Photometry& photometry, int n, double exposure,
                      const ProjectedLight& light);

}  // namespace slipstream
