#include "slipstream/simulate/virtual_scanner.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/simulate/projected_light.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/sensor.h"

namespace slipstream {
namespace {

constexpr double exposed_for = 0.5;  // of a frame, where motion is blurred

/// The scene while the frame of a time is exposed: once, or several times where motion is blurred.
std::vector<SeenScene> looks(const Scanner& scanner, const Scene& scene,
                             const Photometry& photometry, double time) {
  constexpr int times = 4;
  if (!photometry.physics.motion_blur || !is_moving(scene)) {
    std::vector<SeenScene> one;
    one.push_back(look(scanner, scene, photometry, time));
    return one;
  }
  std::vector<SeenScene> seen;
  for (int i = 0; i < times; ++i) {
    seen.push_back(look(scanner, scene, photometry, time + exposed_for * (i + 0.5) / times));
  }
  return seen;
}

Image<double> coordinate_of(const SeenScene& seen, Axis axis, Size projector) {
  Image<double> coordinate = axis == Axis::x ? seen.lit_column : seen.lit_row;
  const int length = length_along(axis, projector);
  for (double& position : coordinate) position /= length;
  return coordinate;
}

}  // namespace

void require_valid(const Photometry& photometry) {
  const auto require = [](bool holds, std::string_view name, double value, std::string_view range) {
    if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
  };
  const int bits = photometry.bits.value_or(8);
  require(std::abs(photometry.ambient) <= 255, "ambient light", photometry.ambient, "-255 to 255");
  const auto* const law = std::get_if<PowerLaw>(&photometry.response);
  const double gamma = law != nullptr ? law->gamma : 1;
  require(gamma >= 0.1 && gamma <= 20, "gamma", gamma, "0.1 to 20");
  require(photometry.noise_variance >= 0 && photometry.noise_variance <= 255.0 * 255,
          "noise variance", photometry.noise_variance, "0 to 255^2");
  require(bits >= 8 && bits <= 16, "bits", bits, "8 to 16");
  require(photometry.rays >= 1 && photometry.rays <= 256, "rays", photometry.rays, "1 to 256");
}

VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry, double time) {
  require_valid(scanner);
  require_valid(photometry);
  const Size projector = scanner.projector.size;
  std::vector<SeenScene> seen = looks(scanner, scene, photometry, time);
  const auto first = std::make_shared<const SeenScene>(seen.front());
  std::vector<Image<double>> exposures;
  for (int n = 0; n < patterns.count; ++n) {
    if (n > 0 && is_moving(scene)) seen = looks(scanner, scene, photometry, time + n);
    Image<double> frame(scanner.camera.size);
    for (const SeenScene& now : seen) {
      const auto light = projected_light(patterns, n, projector, photometry, now);
      const Image<double> exposure = exposed(now, photometry, n, patterns.exposure(n), light);
      const double share = 1.0 / static_cast<double>(seen.size());
      std::transform(frame.begin(), frame.end(), exposure.begin(), frame.begin(),
                     [=](double sum, double more) { return sum + share * more; });
    }
    add_noise(frame, n, photometry);
    exposures.push_back(std::move(frame));
  }
  const double exposure = photometry.physics.motion_blur ? exposed_for : 0;
  const double middle = time + 0.5 * (patterns.count - 1 + exposure);
  const SeenScene truth =
      middle > time && is_moving(scene) ? look(scanner, scene, photometry, middle) : *first;
  return {digitised(std::move(exposures), photometry.bits),
          truth.depth,
          coordinate_of(truth, patterns.axis, projector),
          truth.reflectivity,
          first,
          projector};
}

FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry) {
  require_valid(photometry);
  std::vector<Image<double>> exposures;
  for (int n = 0; n < patterns.count; ++n) {
    exposures.push_back(
        exposed(*scan.seen, photometry, n, patterns.exposure(n),
                projected_light(patterns, n, scan.projector, photometry, *scan.seen)));
    add_noise(exposures.back(), n, photometry);
  }
  return digitised(std::move(exposures), photometry.bits);
}

}  // namespace slipstream
