#include "simulate/seen_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/parallel_rows.h"
#include "decode/equations.h"
#include "simulate/frame_rows.h"
#include "simulate/lens_packet.h"
#include "simulate/ray_packet.h"
#include "simulate/surface_packet.h"
#include "slipstream/named_scenes.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;
using Bodies = std::vector<PlacedBody>;

/// Squared distance from the centre of a picture, 1 in its corners.
double off_centre(const Eigen::Vector2d& pixel, Size size) {
  const Eigen::Vector2d middle(0.5 * size.width, 0.5 * size.height);
  return (pixel - middle).squaredNorm() / middle.squaredNorm();
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

std::vector<Eigen::Vector2d> ray_offsets(int rays) {
  std::vector<Eigen::Vector2d> offsets;
  for (int ray = 0; ray < rays; ++ray) offsets.push_back(ray_offset(ray, rays));
  return offsets;
}

/// The surfaces that the rays of a packet meet, and the light on them.
struct MetPacket {
  std::array<bool, packet_rays> met{}, lit{};
  PacketSurfaces surfaces;
  Lanes reflectivity;
  std::array<LitSample, packet_rays> light{};  ///< of those that are lit
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
  Bodies bodies = placed_at(scene, time);
  /// The projector's lens is known to be invertible up to this tangent.
  double invertible = largest_tangent(scanner.projector).value_or(0);
  std::vector<Eigen::Vector2d> offsets = ray_offsets(photometry.rays);

  /// The bodies as they are when a row is exposed.
  [[nodiscard]] Bodies at_row(int row) const {
    if (!physics.rolling_shutter) return bodies;
    return placed_at(scene, time + rolled(physics, row, scanner.camera.size.height));
  }

  /// What camera rays through these pixels meet, the first `count` of a packet.
  [[nodiscard]] MetPacket along(const Bodies& placed, PacketRays& rays, Lanes column, Lanes row,
                                int count) const {
    for (int i = count; i < packet_rays; ++i) {
      column[i] = column[0];
      row[i] = row[0];
    }
    if (physics.lens_residue != 0) add_residue(column, row);

    LaneVectors directions;
    rays.find(column, row, directions);
    return met(placed, Vector::Zero(), directions, count);
  }

  /// Adds the light that other surfaces reflect onto a pixel's surface.
  void add_bounces(const Bodies& placed, const Eigen::Vector2d& pixel, const Vector& point,
                   const Vector& normal, double alpha, std::vector<LitSample>& samples) const {
    // Each pixel has a direction of its own, from which its rays turn on evenly.
    const auto key = static_cast<std::uint64_t>(pixel.y() * 65536 + pixel.x());
    const double turn = uniform(key);
    const Vector across = normal.unitOrthogonal(), along = normal.cross(across);

    for (int first = 0; first < physics.bounces; first += packet_rays) {
      const int count = std::min(packet_rays, physics.bounces - first);
      LaneVectors directions;

      // Cosine-distributed around the normal.
      for (int i = 0; i < packet_rays; ++i) {
        const int bounce = first + std::min(i, count - 1);
        const double u = (bounce + 0.5) / physics.bounces, radius = std::sqrt(u);
        const double angle = 2 * std::numbers::pi * (turn + bounce / std::numbers::phi);
        directions.set(i, radius * (std::cos(angle) * across + std::sin(angle) * along) +
                              std::sqrt(1 - u) * normal);
      }

      const MetPacket other = met(placed, point + 1e-4 * normal, directions, count);
      for (int i = 0; i < count; ++i) {
        if (!other.lit[i]) continue;
        samples.push_back(other.light[i]);
        samples.back().strength *= alpha / physics.bounces;
      }
    }
  }

 private:
  /// Adds a smooth error that no lens polynomial fits.
  void add_residue(Lanes& column, Lanes& row) const {
    Lanes u, v;
    for (int i = 0; i < packet_rays; ++i) {
      u[i] = 12 * column[i] / scanner.camera.size.width;
      v[i] = 12 * row[i] / scanner.camera.size.width;
    }

    Lanes to_right, down;
    cosines(v, to_right);
    for (int i = 0; i < packet_rays; ++i) {
      to_right[i] += u[i];
      down[i] = v[i] - u[i];
    }
    sines(to_right, to_right);
    cosines(down, down);

    for (int i = 0; i < packet_rays; ++i) {
      column[i] += physics.lens_residue * to_right[i];
      row[i] += physics.lens_residue * down[i];
    }
  }

  [[nodiscard]] MetPacket met(const Bodies& placed, const Vector& origin,
                              const LaneVectors& directions, int count) const {
    MetPacket result;

    // 1. The surfaces.
    Lanes limit;
    for (int i = 0; i < packet_rays; ++i) {
      const bool traced = i < count && std::isfinite(directions.x[i] + directions.y[i]);
      limit[i] = traced ? std::numeric_limits<double>::infinity() : -1;
    }
    const PacketHits hits = first_hits(placed, origin, directions, limit);
    std::ranges::transform(hits.body, result.met.begin(), [](int body) { return body >= 0; });
    if (std::ranges::none_of(result.met, std::identity())) return result;

    result.surfaces = surfaces_of(placed, hits, origin, directions);
    reflect(result.surfaces, light, origin, physics.gloss, result.reflectivity);

    // 2. Those that the projector lights.
    const LightingPixels pixels = lighting_pixels(scanner, light, result.surfaces);
    const Lens& projector = scanner.projector;
    for (int i = 0; i < packet_rays; ++i) {
      result.lit[i] = result.met[i] && pixels.lit[i] > 0;
      if (!result.lit[i] || pixels.tangent2[i] <= invertible * invertible) continue;

      // Far outside the field, the lens model folds back into it.
      const Vector point = in_projector_frame(scanner, result.surfaces.point.at(i));
      const Vector ray = ray_through(projector, {pixels.column[i], pixels.row[i]});
      result.lit[i] = (ray - point / point.z()).isZero(1e-6);
    }
    remove_shadow(placed, result);

    // 3. Their light: with fall-off, the lens's loss, its blur and the spread in the surface.
    for (int i = 0; i < packet_rays; ++i) {
      if (!result.lit[i]) continue;
      const double distance = pixels.distance[i], near = bright_distance / distance;
      const double share = physics.fall_off ? near * near : 1;
      const Eigen::Vector2d pixel(pixels.column[i], pixels.row[i]);
      const double lens_loss = 1 - physics.vignetting * off_centre(pixel, projector.size);
      result.light[i] = {pixel, share * lens_loss * result.reflectivity[i],
                         physics.projector.at(distance / working_distance),
                         physics.translucency * projector.intrinsic(0, 0) / distance};
    }

    return result;
  }

  void remove_shadow(const Bodies& placed, MetPacket& packet) const {
    const auto first = std::ranges::find(packet.lit, true);
    if (first == packet.lit.end()) return;

    // From the light towards the points; those not searched are like the first.
    LaneVectors directions;
    Lanes limit;
    for (int i = 0; i < packet_rays; ++i) {
      const auto from = packet.lit[i] ? i : first - packet.lit.begin();
      directions.x[i] = packet.surfaces.point.x[from] - light.x();
      directions.y[i] = packet.surfaces.point.y[from] - light.y();
      directions.z[i] = packet.surfaces.point.z[from] - light.z();
      limit[i] = packet.lit[i] ? own_surface : -1;
    }

    block(placed, light, directions, limit);
    for (int i = 0; i < packet_rays; ++i) packet.lit[i] = limit[i] > 0;
  }
};

/// Light and surfaces at the pixels' centres, beside what SeenScene has of them.
struct Centres {
  explicit Centres(const SeenScene& seen, bool with_surfaces)
      : light(seen.size.width * seen.size.height), surfaces(with_surfaces ? light.size() : 0) {}

  struct Surface {
    Vector point, normal;
    double alpha = 0;
  };

  std::vector<LitSample> light;
  std::vector<Surface> surfaces;  ///< for bounces; otherwise empty
};

/// What the rays through the centres of a row's pixels meet.
void look_at_centres(const Onlooker& onlooker, int row, SeenScene& seen, Centres& centres) {
  const Bodies placed = onlooker.at_row(row);
  PacketRays rays(onlooker.scanner.camera);

  for (int first = 0; first < seen.size.width; first += packet_rays) {
    const int count = std::min(packet_rays, seen.size.width - first);
    Lanes columns, rows;
    for (int i = 0; i < count; ++i) columns[i] = first + i, rows[i] = row;
    const MetPacket met = onlooker.along(placed, rays, columns, rows, count);

    // The ground truth is at the pixel's centre.
    for (int i = 0; i < count; ++i) {
      const int column = first + i;
      if (!met.met[i]) continue;
      const PacketSurfaces& surfaces = met.surfaces;
      seen.depth(column, row) = surfaces.point.z[i];
      seen.reflectivity(column, row) = seen.albedo(column, row) = met.reflectivity[i];

      const std::size_t pixel = std::size_t(row) * seen.size.width + column;
      if (!centres.surfaces.empty()) {
        centres.surfaces[pixel] = {surfaces.point.at(i), surfaces.normal.at(i), surfaces.alpha[i]};
      }
      if (!met.lit[i]) continue;
      seen.lit_column(column, row) = met.light[i].pixel.x();
      seen.lit_row(column, row) = met.light[i].pixel.y();
      centres.light[pixel] = met.light[i];
    }
  }
}

/// Whether a pixel and its neighbours see one smooth surface with uniform light.
bool is_even(const SeenScene& seen, int column, int row) {
  constexpr double bend = 2e-4;  // of the depth, from pixel to pixel
  constexpr double contrast = 0.02;
  const double depth = seen.depth(column, row), alpha = seen.reflectivity(column, row);
  const bool lit = !std::isnan(seen.lit_column(column, row));

  // At most the half of two neighbours is past the picture's edge, where the centre stands for it.
  const auto straight = [&](int right, int down) {
    double sum = 0;
    for (const int sign : {-1, 1}) {
      const int x = std::clamp(column + sign * right, 0, seen.size.width - 1);
      const int y = std::clamp(row + sign * down, 0, seen.size.height - 1);

      // Lit or not like the centre, with about the same reflectivity.
      const double there = seen.depth(x, y);
      if (std::isnan(there) != std::isnan(depth)) return false;
      if (lit == std::isnan(seen.lit_column(x, y))) return false;
      if (!(std::abs(seen.reflectivity(x, y) - alpha) < contrast)) return false;
      sum += there;
    }

    // Flat within the bend.
    return std::isnan(depth) || std::abs(sum - 2 * depth) < bend * depth;
  };

  // In all four directions: across, down and both diagonals.
  return straight(1, 0) && straight(0, 1) && straight(1, 1) && straight(-1, 1);
}

/// Mean reflectivities and light of several rays through each of some pixels of a row.
struct MeansOfRays {
  std::vector<double> albedo;
  std::vector<LitSample> samples{};
  std::vector<int> sample_count;  ///< for each pixel
};

MeansOfRays means_of_rays(const Onlooker& onlooker, const Bodies& placed, int row,
                          const std::vector<int>& columns) {
  const int rays_of_pixel = onlooker.photometry.rays;
  const int all = rays_of_pixel * static_cast<int>(columns.size());
  PacketRays rays(onlooker.scanner.camera);
  MeansOfRays means{.albedo = std::vector<double>(columns.size()),
                    .sample_count = std::vector<int>(columns.size())};

  for (int first = 0; first < all; first += packet_rays) {
    const int count = std::min(packet_rays, all - first);
    Lanes across, down;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d& offset = onlooker.offsets[(first + i) % rays_of_pixel];
      across[i] = columns[(first + i) / rays_of_pixel] + offset.x();
      down[i] = row + offset.y();
    }

    const MetPacket met = onlooker.along(placed, rays, across, down, count);
    for (int i = 0; i < count; ++i) {
      const int pixel = (first + i) / rays_of_pixel;
      if (!met.met[i]) continue;
      means.albedo[pixel] += met.reflectivity[i] / rays_of_pixel;
      if (!met.lit[i]) continue;
      means.samples.push_back(met.light[i]);
      means.samples.back().strength /= rays_of_pixel;
      ++means.sample_count[pixel];
    }
  }

  return means;
}

/// The light of a row's pixels, from one ray on even surfaces and from several elsewhere.
void light_row(const Onlooker& onlooker, int row, const Centres& centres, SeenScene& seen) {
  const Photometry& photometry = onlooker.photometry;
  const Bodies placed = onlooker.at_row(row);

  // 1. The uneven pixels.
  std::vector<int> uneven;
  for (int column = 0; column < seen.size.width && photometry.rays > 1; ++column) {
    if (!is_even(seen, column, row)) uneven.push_back(column);
  }
  const MeansOfRays means = means_of_rays(onlooker, placed, row, uneven);

  // 2. All of them, in their order.
  std::vector<LitSample>& samples = seen.samples[row];
  std::size_t next = 0;
  auto next_sample = means.samples.begin();
  for (int column = 0; column < seen.size.width; ++column) {
    const std::size_t pixel = std::size_t(row) * seen.size.width + column;
    const std::size_t before = samples.size();
    const double depth = seen.depth(column, row) / onlooker.working_place.z();
    seen.blur(column, row) = photometry.physics.camera.at(std::isnan(depth) ? 1 : depth);

    if (next < uneven.size() && uneven[next] == column) {
      const auto end = next_sample + means.sample_count[next];
      samples.insert(samples.end(), next_sample, end);
      seen.albedo(column, row) = means.albedo[next++];
      next_sample = end;
    } else if (!std::isnan(seen.lit_column(column, row))) {
      samples.push_back(centres.light[pixel]);
    }

    if (!std::isnan(depth) && !centres.surfaces.empty()) {
      const auto& [point, normal, alpha] = centres.surfaces[pixel];
      onlooker.add_bounces(placed, Eigen::Vector2d(column, row), point, normal, alpha, samples);
    }
    seen.sample_count(column, row) = static_cast<int>(samples.size() - before);
  }

  seen.widest[row] = widest_blur(samples);
}

}  // namespace

double widest_blur(std::span<const LitSample> samples) {
  double widest2 = 0;
  for (const LitSample& sample : samples) {
    widest2 = std::max(widest2, sample.blur * sample.blur + sample.spread * sample.spread);
  }
  return std::sqrt(widest2);
}

double rolled(const Physics& physics, double row, int rows) {
  constexpr double from_first_to_last = 0.9;  // frames
  return physics.rolling_shutter ? from_first_to_last * row / rows : 0;
}

SeenScene look(const Scanner& scanner, const Scene& scene, const Photometry& photometry,
               double time, const std::function<bool()>& stopped) {
  const Size size = scanner.camera.size;
  const Onlooker onlooker{scanner, scene, photometry, time};
  SeenScene seen{size};
  Centres centres(seen, photometry.physics.bounces > 0);

  const auto goes_on = [&] { return !stopped || !stopped(); };
  for_each_row(size.height, [&](int row) {
    if (goes_on()) look_at_centres(onlooker, row, seen, centres);
  });
  for_each_row(size.height, [&](int row) {
    if (goes_on()) light_row(onlooker, row, centres, seen);
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
    const std::vector<LitSample>& samples = seen.samples[row];
    std::vector<double> lit(samples.size());
    light(samples, lit.data());

    std::size_t next = 0;
    for (int column = 0; column < size.width; ++column) {
      const double from_middle = (2.0 * column - size.width) / size.width;
      const double beta = photometry.ambient * (1 + physics.ambient_gradient * from_middle);
      double sum = (seen.albedo(column, row) + 1) * beta;

      for (int i = 0; i < seen.sample_count(column, row); ++i, ++next) {
        sum += samples[next].strength * lit[next];
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
  const auto [width, height] = picture.size();
  const double widest = *std::max_element(deviation.begin(), deviation.end());
  const int reach = std::max(1, static_cast<int>(std::ceil(4 * widest)));

  // 1. Along the rows, whose ends are repeated beyond them.
  Image<double> along(picture.size()), result(picture.size());
  for_each_row(height, [&](int row) {
    std::vector<double> wide(width + 2 * reach, picture(0, row));
    std::copy_n(picture.row(row), width, wide.begin() + reach);
    std::fill_n(wide.end() - reach, reach, picture(width - 1, row));

    std::vector<const double*> before, after;
    for (int i = 1; i <= reach; ++i) {
      before.push_back(wide.data() + reach - i);
      after.push_back(wide.data() + reach + i);
    }
    blur_row(wide.data() + reach, before, after, {deviation.row(row), std::size_t(width)},
             along.row(row));
  });

  // 2. Along the columns.
  for_each_row(height, [&](int row) {
    std::vector<const double*> before, after;
    for (int i = 1; i <= reach; ++i) {
      before.push_back(along.row(std::max(row - i, 0)));
      after.push_back(along.row(std::min(row + i, height - 1)));
    }
    blur_row(along.row(row), before, after, {deviation.row(row), std::size_t(width)},
             result.row(row));
  });

  return result;
}

}  // namespace slipstream
