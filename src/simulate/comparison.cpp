#include "simulate/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "base/statistics.h"
#include "simulate/seen_scene.h"
#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

/// Distance of a point to the surfaces within one and a half pixels, mm. `truth_time`: as in
/// VirtualScan.
double distance_to_surfaces(const Cloud& cloud, int column, int row, const VirtualWorld& world,
                            double truth_time) {
  const Eigen::Vector3d point = position_at(cloud, column, row);

  // The surfaces where the truth of this row has them.
  const double later = rolled(world.photometry.physics, row, cloud.size().height);
  const std::vector<PlacedBody> bodies = placed_at(world.scene, truth_time + later);
  double nearest = std::numeric_limits<double>::infinity();

  // Rays at quarter pixels.
  for (double y = row - 1.5; y <= row + 1.5; y += 0.25) {
    for (double x = column - 1.5; x <= column + 1.5; x += 0.25) {
      const Ray ray{Eigen::Vector3d::Zero(), ray_through(world.scanner.camera, {x, y})};
      const auto surface = first_surface(bodies, ray);
      if (surface) nearest = std::min(nearest, (surface->point - point).norm());
    }
  }

  return nearest;
}

/// Standard deviation of depth from scan to scan, mm, from the median difference of two; 0 without
/// common points.
double repeatability(const Cloud& first, const Cloud& second) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < first.z.pixel_count(); ++i) {
    const double difference = std::abs(double{first.z.begin()[i]} - double{second.z.begin()[i]});
    if (std::isfinite(difference)) differences.push_back(difference);
  }

  if (differences.empty()) return 0;
  return deviation_from_median(median(std::move(differences))) / std::sqrt(2.0);
}

/// The world with a share of the light per frame, and correspondingly more gain. A given noise
/// variance counts as shot noise. Offsets in grey levels, of rows and of pixels, stay: they arise
/// behind the amplifier.
VirtualWorld with_exposure(VirtualWorld world, double share) {
  world.photometry.noise_variance /= share;
  world.photometry.physics.full_well *= share;
  for (Body& body : world.scene) body.motion.pace *= share;
  return world;
}

double milliseconds_of(Engine& engine, const FrameSet& frames, Cloud cloud) {
  constexpr int times = 5;
  using Clock = std::chrono::steady_clock;
  double fastest = std::numeric_limits<double>::infinity();

  for (int i = 0; i < times; ++i) {
    const Clock::time_point start = Clock::now();
    engine.cloud(frames, cloud);
    const std::chrono::duration<double, std::milli> taken = Clock::now() - start;
    fastest = std::min(fastest, taken.count());
  }

  return fastest;
}

/// The world's scanner with an ideal calibration.
Scanner fully_calibrated(const VirtualWorld& world) {
  Scanner scanner = as_calibrated(world);

  // Response and gamma as if they had been measured.
  const Response& response = world.photometry.response;
  if (is_linear(response)) return scanner;
  const auto* const law = std::get_if<PowerLaw>(&response);

  scanner.photometry.response.emplace(
      MeasuredResponse{.response = response, .gamma = law != nullptr ? law->gamma : 1});

  return scanner;
}

ComparedSequence judged(const VirtualWorld& world, const Sequence& sequence,
                        const ReconstructSettings& settings) {
  const PatternSet patterns = pattern_set(sequence);
  Engine engine(fully_calibrated(world), sequence, settings);

  const VirtualScan scan = take_scan(world.scanner, world.scene, patterns, world.photometry);
  ComparedSequence result;
  Maps maps;
  engine.cloud_and_maps(scan.frames, result.cloud, maps);
  const Uncertainty sigma = engine.uncertainty(result.cloud, maps, scan.frames);

  result.errors =
      cloud_errors(result.cloud, sigma, maps.coordinate, sequence.strategy.layout(), scan, world);
  result.decode_ms = milliseconds_of(engine, scan.frames, result.cloud);

  // A second scan differs only in its noise.
  if (!is_moving(world.scene)) {
    Photometry again = world.photometry;
    ++again.seed;
    Cloud second;
    engine.cloud(take_again(scan, patterns, again), second);
    result.repeatability = repeatability(result.cloud, second);
  }

  return result;
}

/// Counts of pixels and sums of squared errors.
struct ErrorSums {
  std::size_t points = 0;
  std::size_t lit = 0, measured = 0;  ///< pixels that the projector lights; those with points
  std::size_t on_surface = 0, within_5 = 0, flying = 0, wrong = 0;
  double squares = 0, predicted_squares = 0;  ///< on a surface, mm^2
  double normalised_squares = 0;              ///< within 5 standard deviations
};

/// A point's error, mm. Prefers the pixel's own surface within noise: the nearest one would
/// understate the error on slopes.
double depth_error(double z, double sigma, const Image<double>& depth, int column, int row) {
  const double own = z - depth(column, row);
  return std::abs(own) <= 5 * sigma ? own : nearest_error(z, depth, column, row);
}

CloudErrors errors_from(const ErrorSums& sums) {
  // Empty sets count as 0.
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  };

  const auto root_mean = [](double sum, std::size_t count) {
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
  };

  CloudErrors errors;
  errors.points = sums.points;
  errors.completeness = share(sums.measured, sums.lit);
  errors.rms = root_mean(sums.squares, sums.on_surface);
  errors.predicted = root_mean(sums.predicted_squares, sums.on_surface);
  errors.normalised_rms = root_mean(sums.normalised_squares, sums.within_5);
  errors.beyond_5 = share(sums.points - sums.within_5, sums.points);
  errors.flying = share(sums.flying, sums.points);
  errors.wrong_order = share(sums.wrong, sums.points);

  return errors;
}

}  // namespace

CloudErrors cloud_errors(const Cloud& cloud, const Uncertainty& uncertainty,
                         const Image<float>& coordinate, const Layout& layout,
                         const VirtualScan& truth, const VirtualWorld& world) {
  const double periods = measuring_band(layout).periods;
  ErrorSums sums;

  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    const double y = truth.coordinate(column, row);
    if (std::isfinite(y)) ++sums.lit;
    if (cloud.validity(column, row) != Validity::valid) return;

    // The point counts as wrong if its coordinate is off by half a period or more.
    ++sums.points;
    if (std::isfinite(y)) ++sums.measured;
    if (std::abs(coordinate(column, row) - y) * periods >= 0.5) ++sums.wrong;

    const double sigma = uncertainty.z(column, row);
    const double error = depth_error(cloud.z(column, row), sigma, truth.depth, column, row);
    if (std::abs(error) <= 5 * sigma) {
      ++sums.within_5;
      sums.normalised_squares += std::pow(error / sigma, 2);
    }

    // Far from the depth seen here, it may still lie on a surface nearby: at a steep edge, say.
    const double limit = std::max(5 * sigma, 1.0);
    const double off = std::abs(error) <= limit
                           ? std::abs(error)
                           : distance_to_surfaces(cloud, column, row, world, truth.truth_time);

    if (off > limit) {
      ++sums.flying;
    } else {
      ++sums.on_surface;
      sums.squares += off * off;
      sums.predicted_squares += sigma * sigma;
    }
  });

  return errors_from(sums);
}

std::vector<ComparedSequence> compare(const VirtualWorld& world,
                                      const std::vector<Sequence>& sequences,
                                      const ReconstructSettings& settings) {
  // The longest sequence gets the shortest exposures, so that all take the same time.
  int fewest = std::numeric_limits<int>::max();
  for (const Sequence& sequence : sequences) fewest = std::min(fewest, frame_count(sequence));

  std::vector<ComparedSequence> all;
  for (const Sequence& sequence : sequences) {
    const double share = static_cast<double>(fewest) / frame_count(sequence);
    all.push_back(judged(with_exposure(world, share), sequence, settings));
  }

  return all;
}

}  // namespace slipstream
