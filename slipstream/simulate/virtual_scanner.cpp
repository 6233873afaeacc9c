#include "slipstream/simulate/virtual_scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void require_valid(const Photometry& photometry) {
  const auto require = [](bool holds, std::string_view name, double value, std::string_view range) {
    if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
  };
  const int bits = photometry.bits.value_or(8);
  require(std::isfinite(photometry.ambient), "ambient light", photometry.ambient, "a number");
  const auto* const law = std::get_if<PowerLaw>(&photometry.response);
  const double gamma = law != nullptr ? law->gamma : 1;
  require(gamma >= 0.1 && gamma <= 20, "gamma", gamma, "0.1 to 20");
  require(photometry.noise_variance >= 0 && std::isfinite(photometry.noise_variance),
          "noise variance", photometry.noise_variance, "0 or more");
  require(bits >= 8 && bits <= 16, "bits", bits, "8 to 16");
  require(photometry.rays >= 1 && photometry.rays <= 256, "rays", photometry.rays, "1 to 256");
}

/// A well-mixed 64-bit number for each counter (the finaliser of SplitMix64).
std::uint64_t mixed(std::uint64_t counter) {
  counter += 0x9e3779b97f4a7c15U;
  counter = (counter ^ (counter >> 30)) * 0xbf58476d1ce4e5b9U;
  counter = (counter ^ (counter >> 27)) * 0x94d049bb133111ebU;
  return counter ^ (counter >> 31);
}

/// Standard normal, a function of its arguments alone, so that frames do not depend on the order in
/// which threads render them (Box and Muller).
double gaussian(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel) {
  const std::uint64_t key = mixed(mixed(seed) ^ mixed(frame << 40 ^ pixel));
  constexpr double unit = 0x1p-53;
  const double u = (static_cast<double>(key >> 11) + 0.5) * unit;
  const double v = static_cast<double>(mixed(key) >> 11) * unit;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// What the camera's pixels see in one frame.
struct View {
  explicit View(Size size) : depth(size, nan), coordinate(size, nan), reflectivity(size, 0) {}

  Image<double> depth;
  Image<double> coordinate;
  Image<double> reflectivity;
};

/// The projector pixel that lights a point; nothing in shadow and outside the field.
std::optional<Eigen::Vector2d> lighting_pixel(const Scanner& scanner, const Scene& scene,
                                              const SurfacePoint& surface, int frame) {
  const Lens& projector = scanner.projector;
  const Eigen::Vector3d centre = projector_centre(scanner);
  const Eigen::Vector3d point = in_projector_frame(scanner, surface.point);
  if (point.z() <= 0 || surface.normal.dot(centre - surface.point) <= 0) return std::nullopt;

  const Eigen::Vector2d pixel = project(projector, point);
  const bool in_field = pixel.x() >= -0.5 && pixel.x() < projector.size.width - 0.5 &&
                        pixel.y() >= -0.5 && pixel.y() < projector.size.height - 0.5;
  if (!in_field) return std::nullopt;
  if (!projector.distortion.is_zero()) {
    // Far outside the field the lens model folds back into it.
    const Eigen::Vector3d ray = ray_through(projector, pixel);
    if (!(ray - point / point.z()).isZero(1e-6)) return std::nullopt;
  }
  if (in_shadow(scene, surface.point, centre, frame)) return std::nullopt;
  return pixel;
}

/// Seen from the origin, where the camera is.
double reflectivity(const SurfacePoint& surface, const Eigen::Vector3d& light) {
  constexpr double sharpness = 30;
  const Eigen::Vector3d to_light = (light - surface.point).normalized();
  double alpha = surface.alpha;
  if (surface.shading == Shading::lambertian) alpha *= std::max(0.0, surface.normal.dot(to_light));
  const Eigen::Vector3d half_way = (to_light - surface.point.normalized()).normalized();
  return std::clamp(alpha, 0.0, 1.0) +
         surface.gloss * std::pow(std::max(0.0, surface.normal.dot(half_way)), sharpness);
}

/// `offset`: of the rays from the pixels' centres.
View look(const Scanner& scanner, const Scene& scene, Axis axis, int frame,
          const Eigen::Vector2d& offset) {
  const Size size = scanner.camera.size;
  const Eigen::Vector3d light = projector_centre(scanner);
  View view(size);
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const Ray ray{Eigen::Vector3d::Zero(),
                    ray_through(scanner.camera, Eigen::Vector2d(column, row) + offset)};
      if (!ray.direction.allFinite()) continue;
      const std::optional<SurfacePoint> surface = first_surface(scene, ray, frame);
      if (!surface) continue;
      view.depth(column, row) = surface->distance;
      view.reflectivity(column, row) = reflectivity(*surface, light);
      if (const auto pixel = lighting_pixel(scanner, scene, *surface, frame)) {
        view.coordinate(column, row) = coordinate_along(axis, *pixel, scanner.projector.size);
      }
    }
  });
  return view;
}

/// Ray `ray` of `rays` from the pixel's centre, pixels. In columns and in rows alike they are
/// evenly spread, no two the same: a lattice of two numbers, one a step of about the golden
/// section.
Eigen::Vector2d ray_offset(int ray, int rays) {
  int step = std::max(1, static_cast<int>(std::lround(rays / std::numbers::phi)));
  while (std::gcd(step, rays) != 1) ++step;
  const Eigen::Vector2d place(ray, ray * step % rays);
  return (place + Eigen::Vector2d(0.5, 0.5)) / rays - Eigen::Vector2d(0.5, 0.5);
}

/// Adds to frame n, grey levels of 8 bits, `share` of what the rays of `view`, a View or a
/// VirtualScan, bring.
template <class Seen>
void add_light(Image<double>& frame, const Seen& view, const PatternSet& patterns, int n,
               const Photometry& photometry, double share) {
  const double beta = photometry.ambient;
  const bool linear = photometry.response == Response(PowerLaw{1});
  const double weight = share * patterns.exposure(n);
  for_each_row(frame.height(), [&](int row) {
    for (int column = 0; column < frame.width(); ++column) {
      const double y = view.coordinate(column, row);
      double projected = std::isnan(y) ? 0 : patterns.intensity(n, y);
      if (!linear) projected = 255 * light_at(photometry.response, projected / 255);  // (4.2)
      const double alpha = view.reflectivity(column, row);
      frame(column, row) += weight * (alpha * (projected + beta) + beta);  // (3.2)
    }
  });
}

void add_noise(Image<double>& frame, int n, const Photometry& photometry) {
  const double noise = std::sqrt(photometry.noise_variance);
  if (noise == 0) return;
  for_each_row(frame.height(), [&](int row) {
    for (int column = 0; column < frame.width(); ++column) {
      const auto pixel =
          static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(frame.width()) +
          static_cast<std::uint64_t>(column);
      frame(column, row) +=
          noise * gaussian(photometry.seed, static_cast<std::uint64_t>(n), pixel);  // (3.10)
    }
  });
}

template <class Pixel>
Image<Pixel> quantised(const Image<double>& exposure, int bits) {
  const double full_scale = (1 << bits) - 1;
  Image<Pixel> frame(exposure.size());
  std::transform(exposure.begin(), exposure.end(), frame.begin(), [&](double intensity) {
    return static_cast<Pixel>(std::lround(std::clamp(intensity / 255, 0.0, 1.0) * full_scale));
  });
  return frame;
}

template <class Pixel>
std::vector<Image<Pixel>> all_quantised(const std::vector<Image<double>>& exposures, int bits) {
  std::vector<Image<Pixel>> frames;
  for (const Image<double>& exposure : exposures)
    frames.push_back(quantised<Pixel>(exposure, bits));
  return frames;
}

FrameSet digitised(std::vector<Image<double>> exposures, std::optional<int> bits) {
  if (!bits) return FrameSet(std::move(exposures));
  if (*bits == 8) return FrameSet(all_quantised<std::uint8_t>(exposures, 8));
  return {all_quantised<std::uint16_t>(exposures, *bits), *bits};
}

}  // namespace

VirtualScan take_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                      const Photometry& photometry) {
  require_valid(scanner);
  require_valid(photometry);
  const bool moving = std::any_of(scene.begin(), scene.end(),
                                  [](const Body& body) { return !body.motion.isZero(0); });

  const int rays = photometry.rays;
  const Axis axis = patterns.axis;
  View first = look(scanner, scene, axis, 0, Eigen::Vector2d::Zero());
  std::vector<Image<double>> exposures(static_cast<std::size_t>(patterns.count),
                                       Image<double>(scanner.camera.size));
  for (int ray = 0; ray < rays; ++ray) {
    const Eigen::Vector2d offset = ray_offset(ray, rays);
    const std::optional<View> beside =
        rays == 1 ? std::nullopt : std::optional(look(scanner, scene, axis, 0, offset));
    for (int n = 0; n < patterns.count; ++n) {
      const std::optional<View> moved =
          n == 0 || !moving ? std::nullopt : std::optional(look(scanner, scene, axis, n, offset));
      const View& view = moved ? *moved : beside ? *beside : first;
      add_light(exposures[static_cast<std::size_t>(n)], view, patterns, n, photometry, 1.0 / rays);
    }
  }
  for (int n = 0; n < patterns.count; ++n) {
    add_noise(exposures[static_cast<std::size_t>(n)], n, photometry);
  }
  return {digitised(std::move(exposures), photometry.bits), std::move(first.depth),
          std::move(first.coordinate), std::move(first.reflectivity)};
}

FrameSet take_again(const VirtualScan& scan, const PatternSet& patterns,
                    const Photometry& photometry) {
  require_valid(photometry);
  std::vector<Image<double>> exposures(static_cast<std::size_t>(patterns.count),
                                       Image<double>(scan.depth.size()));
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& frame = exposures[static_cast<std::size_t>(n)];
    add_light(frame, scan, patterns, n, photometry, 1);
    add_noise(frame, n, photometry);
  }
  return digitised(std::move(exposures), photometry.bits);
}

}  // namespace slipstream
