#include "slipstream/simulate/colour_camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/codes/primaries.h"
#include "slipstream/simulate/sensor.h"

namespace slipstream {
namespace {

constexpr std::size_t channels = 3;

/// Which share of its light channel c keeps of paint at that place of the surface.
double kept(double paint, const Eigen::Vector3d& point, std::size_t c) {
  constexpr double around = 40;  // mm
  const double hue = (point.x() + point.y()) / around - static_cast<double>(c) / channels;
  return 1 - paint * (0.5 + 0.5 * std::cos(2 * std::numbers::pi * hue));
}

/// The channels of one picture, before the sensor, of what each projector colour alone would give.
std::vector<Image<double>> mixed(const std::vector<ImageView<const double>>& lights,
                                 const VirtualScan& seen, const Lens& camera,
                                 const ColourDevices& devices) {
  const Size size = lights.front().size();
  std::vector<Image<double>> picture(channels, Image<double>(size));
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const double depth = seen.depth(column, row);
      const Eigen::Vector3d point =
          std::isnan(depth) ? Eigen::Vector3d::Zero()
                            : Eigen::Vector3d(depth * ray_through(camera, {column, row}));
      for (std::size_t c = 0; c < channels; ++c) {
        double sum = 0;
        for (std::size_t p = 0; p < channels; ++p) {
          sum += devices.mixture[c][p] * lights[p](column, row);
        }
        picture[c](column, row) = kept(devices.paint, point, c) * sum;
      }
    }
  });
  return picture;
}

}  // namespace

VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices) {
  if (patterns.count % static_cast<int>(channels) != 0) {
    throw Error(
        fmt::format("{} patterns do not make whole pictures of three in colour", patterns.count));
  }
  if (is_moving(scene)) throw Error("a scene in colour stands still");
  if (!(devices.paint >= 0 && devices.paint <= 1)) {
    throw Error(fmt::format("paint {} is out of range; 0 to 1", devices.paint));
  }
  Photometry light = photometry;
  light.bits.reset();
  light.noise_variance = 0;
  VirtualScan scan = take_scan(scanner, scene, patterns, light);
  const auto seen_in_colour = [&](const FrameSet& lights, int first_noise) {
    std::vector<Image<double>> exposures;
    lights.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
      if constexpr (std::is_same_v<Pixel, double>) {
        for (std::size_t n = 0; n < frames.size(); n += channels) {
          for (Image<double>& channel :
               mixed({frames[n], frames[n + 1], frames[n + 2]}, scan, scanner.camera, devices)) {
            add_noise(channel, first_noise + static_cast<int>(exposures.size()), photometry);
            exposures.push_back(std::move(channel));
          }
        }
      }
    });
    return digitised(std::move(exposures), photometry.bits);
  };
  scan.white =
      seen_in_colour(take_again(scan, white_pattern(patterns.light), light), patterns.count);
  scan.frames = seen_in_colour(scan.frames, 0);
  scan.in_colour = true;
  return scan;
}

}  // namespace slipstream
