#include "reconstruct/epipolar.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "decode/band_unwrapper.h"
#include "decode/decoder.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/engine_setup.h"
#include "response/correction.h"

namespace slipstream {
namespace {

constexpr double least_limit = 0.5;  // projector pixels: error of a calibration

/// Maps of the scan along the other axis.
BasicMaps<double> maps_across(EngineSetup setup, const Scan& other) {
  throw_if(!has_coordinate(setup.sequence.strategy),
           "comparing both axes requires a strategy that gives a coordinate along each axis alone");

  setup.sequence = other.sequence;
  const Decoder decode(setup.sequence.strategy.layout(), projector_length(setup),
                       setup.settings.phase_method, phase_corrections(setup), cue_settings(setup));
  return decode(other.frames,
                least_neighbour_modulation(setup.settings, other.frames.full_scale()));
}

/// Marks points off their epipolar lines as doubtful; returns how many.
std::size_t leave_out_doubtful(Cloud& cloud, const Image<float>& off, const Image<float>& sigma) {
  std::size_t points = 0, doubted = 0;

  // The distance is NaN where the lens model does not reach a wrong coordinate: too far, too.
  const auto too_far = [&](int column, int row) {
    const double limit = std::max(least_limit, 5.0 * sigma(column, row));
    return sigma(column, row) > 0 && !(std::abs(off(column, row)) <= limit);
  };

  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    ++points;
    doubted += too_far(column, row) ? 1 : 0;
  });

  // If more than a third are off, the rest are close only by chance.
  const bool all = 3 * doubted > points;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) == Validity::valid && (all || too_far(column, row)))
      cloud.leave_out(column, row, Validity::doubtful_order);
  });

  return all ? points : doubted;
}

/// Medians over the points, before any is rejected.
EpipolarCheck summary_of(const Image<float>& distance, const Image<float>& sigma,
                         const Cloud& cloud) {
  std::vector<double> distances, lengths, sigmas;
  for (std::size_t i = 0; i < sigma.pixel_count(); ++i) {
    const float off = distance.begin()[i];
    if (cloud.validity.begin()[i] != Validity::valid || std::isnan(off)) continue;
    distances.push_back(off);
    lengths.push_back(std::abs(off));
    sigmas.push_back(sigma.begin()[i]);
  }

  if (distances.empty()) return {};
  return {.median = median(std::move(distances)),
          .median_length = median(std::move(lengths)),
          .median_sigma = median(std::move(sigmas))};
}

}  // namespace

EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y) {
  // The undistorted ray of the projector pixel.
  const Lens& projector = scanner.projector;
  const Eigen::Vector3d q =
      ray_through(projector, {x * projector.size.width, y * projector.size.height});

  // The epipolar plane holds the baseline and the camera's ray; it cuts the projector's image in
  // the epipolar line, in undistorted pixels.
  const Eigen::Vector3d plane = scanner.translation.cross(scanner.rotation * ray);
  const Eigen::Vector2d line =
      projector.intrinsic.inverse().transpose().topLeftCorner<2, 3>() * plane;

  const double length = line.norm();
  return {q.dot(plane) / length, line / length};
}

bool EpipolarCheck::contradicts() const {
  return median_length > least_limit && median_length > 3 * median_sigma;
}

EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps,
                             Cloud& cloud) {
  // 1. The coordinate along the other axis, and which of its pixels are bright enough.
  const BasicMaps<double> other_maps = maps_across(setup, other);
  const double grey_level = other.frames.full_scale() / 255;
  const double least = least_modulation(setup.settings, other.frames.full_scale());
  const Image<std::uint8_t> saturated = saturation_mask(other.frames);

  // 2. The deviation of a coordinate, fields: of sinusoids inversely proportional to B.
  const Layout& layout = setup.sequence.strategy.layout();
  const double unit = std::sqrt(coordinate_variance(layout, 1, cue_settings(setup).noise_variance));

  const auto sigma_of = [&](double modulation) {
    return layout.unwrapping->whole_stripes ? unit : unit * grey_level / modulation;
  };

  // 3. Distances from the epipolar line and their deviations, projector pixels.
  const auto [width, height] = setup.scanner.projector.size;
  const Size size = cloud.size();
  Image<float> off(size, static_cast<float>(nan)), sigma(size);

  for_each_pixel(size, [&](int column, int row) {
    const double B = maps.modulation(column, row), other_B = other_maps.modulation(column, row);
    if (!(std::min(B, other_B) >= least) || saturated(column, row) != 0) return;

    const auto [distance, normal] =
        epipolar_distance(setup.scanner, ray_through(setup.scanner.camera, {column, row}),
                          maps.coordinate(column, row), other_maps.coordinate(column, row));
    off(column, row) = static_cast<float>(distance);

    sigma(column, row) = static_cast<float>(
        std::hypot(normal.x() * width * sigma_of(B), normal.y() * height * sigma_of(other_B)));
  });

  // 4. Judge the points by their distances.
  EpipolarCheck check = summary_of(off, sigma, cloud);
  check.doubted = leave_out_doubtful(cloud, off, sigma);
  maps.epipolar_distance = std::move(off);
  return check;
}

}  // namespace slipstream
