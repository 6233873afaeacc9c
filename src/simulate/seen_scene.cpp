#include "simulate/seen_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <stop_token>
#include <type_traits>
#include <vector>

#include "base/parallel_rows.h"
#include "decode/equations.h"
#include "slipstream/named_scenes.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

/// Squared distance from the centre of a picture, 1 in its corners.
double off_centre(const Eigen::Vector2d& pixel, Size size) {
  const Eigen::Vector2d middle(0.5 * size.width, 0.5 * size.height);
  return (pixel - middle).squaredNorm() / middle.squaredNorm();
}

/// The projector pixel that lights a point; nullopt in shadow or outside the field.
std::optional<Eigen::Vector2d> lighting_pixel(const Scanner& scanner,
                                              const std::vector<PlacedBody>& bodies,
                                              const SurfacePoint& surface) {
  const Lens& projector = scanner.projector;
  const Vector centre = projector_centre(scanner);
  const Vector point = in_projector_frame(scanner, surface.point);
  if (point.z() <= 0 || surface.normal.dot(centre - surface.point) <= 0) return std::nullopt;

  const Eigen::Vector2d pixel = project(projector, point);
  const bool in_field = pixel.x() >= -0.5 && pixel.x() < projector.size.width - 0.5 &&
                        pixel.y() >= -0.5 && pixel.y() < projector.size.height - 0.5;
  if (!in_field) return std::nullopt;

  if (!is_straight(projector)) {
    // Far outside the field, the lens model folds back into it.
    const Vector ray = ray_through(projector, pixel);
    if (!(ray - point / point.z()).isZero(1e-6)) return std::nullopt;
  }

  if (in_shadow(bodies, surface.point, centre)) return std::nullopt;
  return pixel;
}

/// Offset from the pixel's centre, pixels. A golden-section lattice spreads the rays evenly in
/// columns and rows.
Eigen::Vector2d ray_offset(int ray, int rays) {
  // The step has no divisor in common with the number of rays, so each ray gets its own row.
  int step = std::max(1, static_cast<int>(std::lround(rays / std::numbers::phi)));
  while (std::gcd(step, rays) != 1) ++step;

  const Eigen::Vector2d place(ray, ray * step % rays);
  return (place + Eigen::Vector2d(0.5, 0.5)) / rays - Eigen::Vector2d(0.5, 0.5);
}

/// A cosine-distributed direction around `normal`; u and v in [0, 1).
Vector diffuse_direction(const Vector& normal, double u, double v) {
  const Vector across = normal.unitOrthogonal(), along = normal.cross(across);
  const double radius = std::sqrt(u), angle = 2 * std::numbers::pi * v;
  return radius * (std::cos(angle) * across + std::sin(angle) * along) + std::sqrt(1 - u) * normal;
}

/// The surface that a camera ray meets, and the light on it.
struct Met {
  SurfacePoint surface;
  double reflectivity = 0;
  std::optional<LitSample> light{};
};

struct Onlooker {
  const Scanner& scanner;
  const Scene& scene;
  const Photometry& photometry;
  double time = 0;
  const Physics& physics = photometry.physics;
  Vector light = projector_centre(scanner);
  Vector working_place = working_volume(scanner).centre;
  double working_distance = (working_place - light).norm();  ///< from the projector
  /// Distance at which the light is nominal.
  double bright_distance = working_distance - working_volume(scanner).extent / 4;
  std::vector<PlacedBody> bodies = placed_at(scene, time);

  [[nodiscard]] std::optional<Met> along(const Eigen::Vector2d& pixel) const {
    const Vector direction = ray_through(scanner.camera, pixel + residue(pixel));
    if (!direction.allFinite()) return std::nullopt;

    const Ray ray{Vector::Zero(), direction};
    return at_row_of(pixel, [&](const auto& placed) { return met(ray, placed); });
  }

  /// Adds the light that other surfaces reflect onto a pixel's surface.
  void add_bounces(const Eigen::Vector2d& pixel, const SurfacePoint& from,
                   std::vector<LitSample>& samples) const {
    // Each pixel has a direction of its own, from which its rays turn on evenly.
    const auto key = static_cast<std::uint64_t>(pixel.y() * 65536 + pixel.x());
    const double turn = uniform(key);

    at_row_of(pixel, [&](const auto& placed) {
      for (int i = 0; i < physics.bounces; ++i) {
        const double u = (i + 0.5) / physics.bounces;
        const Vector direction = diffuse_direction(from.normal, u, turn + i / std::numbers::phi);
        const std::optional<Met> other = met({from.point + 1e-4 * from.normal, direction}, placed);

        if (!other || !other->light) continue;
        samples.push_back(*other->light);
        samples.back().strength *= from.alpha / physics.bounces;
      }
    });
  }

  /// Calls `use` with the bodies as they are when the pixel's row is exposed.
  template <class Use>
  std::invoke_result_t<Use, const std::vector<PlacedBody>&> at_row_of(const Eigen::Vector2d& pixel,
                                                                      const Use& use) const {
    if (!physics.rolling_shutter) return use(bodies);
    const double later = rolled(physics, pixel.y(), scanner.camera.size.height);
    return use(placed_at(scene, time + later));
  }

  /// A smooth error that no lens polynomial fits.
  [[nodiscard]] Eigen::Vector2d residue(const Eigen::Vector2d& pixel) const {
    if (physics.lens_residue == 0) return Eigen::Vector2d::Zero();
    const double u = 12 * pixel.x() / scanner.camera.size.width;
    const double v = 12 * pixel.y() / scanner.camera.size.width;
    return physics.lens_residue * Eigen::Vector2d(std::sin(u + std::cos(v)), std::cos(v - u));
  }

  /// `eye`: origin of the ray.
  [[nodiscard]] double reflectivity(const SurfacePoint& surface, const Vector& eye) const {
    constexpr double sharpness = 30;
    const Vector to_light = (light - surface.point).normalized();
    double alpha = surface.alpha;
    if (surface.shading == Shading::lambertian) {
      alpha *= std::max(0.0, surface.normal.dot(to_light));
    }

    // The highlight, where the normal is half way between the light and the eye.
    const Vector half_way = (to_light + (eye - surface.point).normalized()).normalized();
    return std::clamp(alpha, 0.0, 1.0) +
           (surface.gloss + physics.gloss) *
               std::pow(std::max(0.0, surface.normal.dot(half_way)), sharpness);
  }

  [[nodiscard]] std::optional<Met> met(const Ray& ray,
                                       const std::vector<PlacedBody>& placed) const {
    const std::optional<SurfacePoint> surface = first_surface(placed, ray);
    if (!surface) return std::nullopt;

    const double distance = (surface->point - light).norm();
    Met result{*surface, reflectivity(*surface, ray.origin)};

    // Lit by the projector: with fall-off, its lens's loss, its blur and the spread in the surface.
    const double share = physics.fall_off ? std::pow(bright_distance / distance, 2) : 1;
    if (const auto pixel = lighting_pixel(scanner, placed, *surface)) {
      const double lens_loss = 1 - physics.vignetting * off_centre(*pixel, scanner.projector.size);
      result.light = {*pixel, share * lens_loss * result.reflectivity,
                      physics.projector.at(distance / working_distance),
                      physics.translucency * scanner.projector.intrinsic(0, 0) / distance};
    }

    return result;
  }
};

/// Surfaces met by the rays through the pixels' centres.
struct MetByCentres {
  Size size;
  std::vector<std::optional<Met>> met;

  /// Clamps to the picture.
  [[nodiscard]] std::optional<Met>& at(int column, int row) {
    const int x = std::clamp(column, 0, size.width - 1), y = std::clamp(row, 0, size.height - 1);
    return met[y * size.width + x];
  }
};

/// Whether a pixel and its neighbours see one smooth surface with uniform light.
bool is_even(MetByCentres& met, int column, int row) {
  constexpr double bend = 2e-4;  // of the depth, from pixel to pixel
  constexpr double contrast = 0.02;
  const std::optional<Met>& here = met.at(column, row);

  const auto beside = [&](int right, int down) -> const std::optional<Met>& {
    return met.at(column + right, row + down);
  };

  // Lit or not like the centre, with about the same reflectivity.
  const auto alike = [&](const std::optional<Met>& other) {
    if (!here || !other) return !here && !other;
    return here->light.has_value() == other->light.has_value() &&
           std::abs(here->reflectivity - other->reflectivity) < contrast;
  };

  // Two opposite neighbours with the centre between them: flat within the bend.
  const auto straight = [&](const std::optional<Met>& one, const std::optional<Met>& other) {
    if (!alike(one) || !alike(other)) return false;
    if (!here) return true;
    const double depth = here->surface.point.z();
    return std::abs(one->surface.point.z() + other->surface.point.z() - 2 * depth) < bend * depth;
  };

  // In all four directions: across, down and both diagonals.
  return straight(beside(-1, 0), beside(1, 0)) && straight(beside(0, -1), beside(0, 1)) &&
         straight(beside(-1, -1), beside(1, 1)) && straight(beside(-1, 1), beside(1, -1));
}

void add_mean_of_rays(const Onlooker& onlooker, const Eigen::Vector2d& pixel, double& albedo,
                      std::vector<LitSample>& samples) {
  albedo = 0;

  for (int ray = 0; ray < onlooker.photometry.rays; ++ray) {
    const auto met = onlooker.along(pixel + ray_offset(ray, onlooker.photometry.rays));
    if (!met) continue;
    albedo += met->reflectivity / onlooker.photometry.rays;
    if (!met->light) continue;
    samples.push_back(*met->light);
    samples.back().strength /= onlooker.photometry.rays;
  }
}

/// Convolves along one direction with a Gaussian whose `deviation` varies from pixel to pixel.
Image<double> blurred_along(const Image<double>& picture, const Image<double>& deviation, int right,
                            int down) {
  Image<double> result(picture.size());
  for_each_row(picture.height(), [&](int row) {
    std::vector<double> weight;  // by distance
    for (int column = 0; column < picture.width(); ++column) {
      const double sigma = std::max(deviation(column, row), 1e-3);
      const int reach = static_cast<int>(std::ceil(4 * sigma));
      weight.resize(reach + 1);
      for (int i = 0; i <= reach; ++i) weight[i] = std::exp(-0.5 * i * i / (sigma * sigma));

      double sum = 0, weights = 0;
      for (int i = -reach; i <= reach; ++i) {
        const int x = std::clamp(column + i * right, 0, picture.width() - 1);
        const int y = std::clamp(row + i * down, 0, picture.height() - 1);
        sum += weight[std::abs(i)] * picture(x, y);
        weights += weight[std::abs(i)];
      }

      result(column, row) = sum / weights;
    }
  });

  return result;
}

}  // namespace

double rolled(const Physics& physics, double row, int rows) {
  constexpr double from_first_to_last = 0.9;  // frames
  return physics.rolling_shutter ? from_first_to_last * row / rows : 0;
}

SeenScene look(const Scanner& scanner, const Scene& scene, const Photometry& photometry,
               double time, const std::stop_token& stop) {
  // 1. The surface that each pixel's centre ray meets.
  const Size size = scanner.camera.size;
  const Onlooker onlooker{scanner, scene, photometry, time};
  MetByCentres met{size, std::vector<std::optional<Met>>(size.width * size.height)};
  for_each_pixel(size, [&](int column, int row) {
    if (stop.stop_requested()) return;
    met.at(column, row) = onlooker.along(Eigen::Vector2d(column, row));
  });

  // 2. The light of each pixel, from one ray on even surfaces and from several elsewhere.
  SeenScene seen{size};
  for_each_row(size.height, [&](int row) {
    if (stop.stop_requested()) return;
    std::vector<LitSample>& samples = seen.samples[row];

    for (int column = 0; column < size.width; ++column) {
      const Eigen::Vector2d pixel(column, row);
      const std::size_t before = samples.size();
      const std::optional<Met>& centre = met.at(column, row);

      // The ground truth is at the pixel's centre.
      if (centre) {
        seen.depth(column, row) = centre->surface.point.z();
        seen.reflectivity(column, row) = seen.albedo(column, row) = centre->reflectivity;
        if (centre->light) {
          seen.lit_column(column, row) = centre->light->pixel.x();
          seen.lit_row(column, row) = centre->light->pixel.y();
        }
      }

      const double depth = seen.depth(column, row) / onlooker.working_place.z();
      seen.blur(column, row) = photometry.physics.camera.at(std::isnan(depth) ? 1 : depth);

      if (photometry.rays > 1 && !is_even(met, column, row)) {
        add_mean_of_rays(onlooker, pixel, seen.albedo(column, row), samples);
      } else if (centre && centre->light) {
        samples.push_back(*centre->light);
      }

      if (centre) onlooker.add_bounces(pixel, centre->surface, samples);
      seen.sample_count(column, row) = static_cast<int>(samples.size() - before);
    }
  });

  return seen;
}

Image<double> exposed(const SeenScene& seen, const Photometry& photometry, int n, double exposure,
                      const ProjectedLight& light) {
  const Physics& physics = photometry.physics;
  const Size size = seen.size;
  // A frequency that is incommensurable with any number of steps.
  const double flicker = 1 + physics.flicker * std::sin(2.4 * n + 1);

  Image<double> frame(size);
  for_each_row(size.height, [&](int row) {
    auto sample = seen.samples[row].begin();
    for (int column = 0; column < size.width; ++column) {
      const double from_middle = (2.0 * column - size.width) / size.width;
      const double beta = photometry.ambient * (1 + physics.ambient_gradient * from_middle);
      double sum = (seen.albedo(column, row) + 1) * beta;

      for (int i = 0; i < seen.sample_count(column, row); ++i, ++sample) {
        sum += sample->strength * light(*sample);
      }

      const double lens_loss =
          1 - physics.vignetting * off_centre(Eigen::Vector2d(column, row), size);
      frame(column, row) = exposure * flicker * lens_loss * sum;
    }
  });

  if (physics.camera == Sharpness{}) return frame;
  return blurred_picture(frame, seen.blur);
}

Image<double> blurred_picture(const Image<double>& picture, const Image<double>& deviation) {
  return blurred_along(blurred_along(picture, deviation, 1, 0), deviation, 0, 1);
}

}  // namespace slipstream
