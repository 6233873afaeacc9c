#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

// Random numbers are pure functions of their arguments, so that frames do not depend on the order
// of rendering threads.

/// A well-mixed 64-bit number for each counter (the finaliser of SplitMix64).
constexpr std::uint64_t mixed(std::uint64_t counter) {
  counter += 0x9e3779b97f4a7c15U;
  counter = (counter ^ (counter >> 30)) * 0xbf58476d1ce4e5b9U;
  counter = (counter ^ (counter >> 27)) * 0x94d049bb133111ebU;
  return counter ^ (counter >> 31);
}

/// In (0, 1).
constexpr double uniform(std::uint64_t key) {
  return (static_cast<double>(mixed(key) >> 11) + 0.5) * 0x1p-53;
}

/// Standard normal (Box and Muller).
inline double gaussian(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel) {
  const std::uint64_t key = mixed(seed) ^ mixed(frame << 40 ^ pixel);
  return std::sqrt(-2 * std::log(uniform(key))) * std::cos(two_pi * uniform(mixed(key)));
}

/// Light that reaches a camera pixel from a position in the projector's picture.
struct LitSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the projector
  double strength = 0;  ///< of the projector's light: reflectivity, fall-off, share of the pixel
  double blur = 0;      ///< standard deviation of the projector's Gaussian, projector pixels
  double spread = 0;    ///< the same for the half of the light scattered within the surface
};

/// A scene as seen by the camera at one time, for frames of any patterns and noise.
struct SeenScene {
  Size size;                         ///< of the camera
  Image<double> depth{size, nan};    ///< at the pixels' centres, mm; NaN without a surface
  Image<double> reflectivity{size};  ///< alpha with shading and gloss; 0 without a surface
  Image<double> albedo{size};        ///< mean alpha of a pixel, for ambient light
  Image<double> blur{size};          ///< standard deviation of the camera's Gaussian, pixels
  /// The projector's pixel that lights a pixel's centre; NaN in shadow and outside the field.
  Image<double> lit_column{size, nan}, lit_row{size, nan};
  /// For each row, pixel by pixel.
  std::vector<std::vector<LitSample>> samples = std::vector<std::vector<LitSample>>(size.height);
  Image<int> sample_count{size};                                  ///< for each pixel
  std::vector<double> widest = std::vector<double>(size.height);  ///< blur of each row's samples
};

/// The widest blur of any sample, with its spread, projector pixels.
double widest_blur(std::span<const LitSample> samples);

/// How much later than the first row a row is exposed, frames; 0 without a rolling shutter.
double rolled(const Physics& physics, double row, int rows);

/// `time`: in frames, 0 at the first; of the first row for a rolling shutter. On even surfaces a
/// pixel uses the ray through its centre, at edges the mean of `photometry.rays` rays.
/// Once `stopped` says true, returns soon, with pixels left dark.
SeenScene look(const Scanner& scanner, const Scene& scene, const Photometry& photometry,
               double time, const std::function<bool()>& stopped = {});

/// Light of positions in the projector's picture under blur, grey levels of 8 bits.
class ProjectedLight {
 public:
  /// `light`: of one sample.
  template <std::invocable<const LitSample&> Light>
  ProjectedLight(Light light)
      : of_samples_([light = std::move(light)](std::span<const LitSample> samples, double* to) {
          std::ranges::transform(samples, to, std::cref(light));
        }) {}

  /// `light`: of several samples, into an array of their number.
  template <std::invocable<std::span<const LitSample>, double*> Light>
  ProjectedLight(Light light) : of_samples_(std::move(light)) {}

  double operator()(const LitSample& sample) const {
    double light = 0;
    of_samples_({&sample, 1}, &light);
    return light;
  }
  void operator()(std::span<const LitSample> samples, double* light) const {
    of_samples_(samples, light);
  }

 private:
  std::function<void(std::span<const LitSample>, double*)> of_samples_;
};

/// Frame n before sensor noise, grey levels of 8 bits: I = alpha (I^p + beta) + beta, Eq. (3.2),
/// plus the effects of Physics. `exposure`: relative to the usual one.
Image<double> exposed(const SeenScene& seen, const Photometry& photometry, int n, double exposure,
                      const ProjectedLight& light);

/// The picture convolved with a Gaussian whose `deviation`, pixels, varies from pixel to pixel.
Image<double> blurred_picture(const Image<double>& picture, const Image<double>& deviation);

}  // namespace slipstream
