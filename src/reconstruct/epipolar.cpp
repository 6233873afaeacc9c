#include "reconstruct/epipolar.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>
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

/// A quadratic function of the place in the picture: the part of the distances that errors of the
/// calibration explain, as of a principal point, a small turn or a lens.
struct CommonDistance {
  using Terms = Eigen::Vector<double, 6>;

  Terms factors = Terms::Zero();
  Size size;

  /// (1, u, v, uu, uv, vv) with u and v from -1 to 1 across the picture.
  [[nodiscard]] Terms terms(int column, int row) const {
    const double u = 2.0 * column / size.width - 1, v = 2.0 * row / size.height - 1;
    return {1, u, v, u * u, u * v, v * v};
  }
  [[nodiscard]] double at(int column, int row) const { return factors.dot(terms(column, row)); }
};

/// A point that is compared.
struct ComparedPoint {
  CommonDistance::Terms terms;
  double distance = 0, sigma = 0;
};

/// The valid points with a distance; at most about `most_compared`, evenly spread.
std::vector<ComparedPoint> compared_points(const Image<float>& off, const Image<float>& sigma,
                                           const Cloud& cloud) {
  constexpr double most_compared = 1e5;
  const auto valid = static_cast<double>(point_count(cloud));
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(valid / most_compared))));

  const CommonDistance place{.size = cloud.size()};
  std::vector<ComparedPoint> points;
  for (int row = 0; row < cloud.size().height; row += step) {
    for (int column = 0; column < cloud.size().width; column += step) {
      const double distance = off(column, row);
      if (cloud.validity(column, row) != Validity::valid || std::isnan(distance)) continue;
      points.push_back({place.terms(column, row), distance, sigma(column, row)});
    }
  }
  return points;
}

/// The common part of the distances, by least squares. Points far from it have no weight, so that
/// a minority of wrong coordinates does not bend it.
CommonDistance common_distance(const std::vector<ComparedPoint>& points, Size size) {
  CommonDistance common{.size = size};
  if (points.empty()) return common;

  // 1. Start with the median; a few points tell no more.
  std::vector<double> distances(points.size());
  std::ranges::transform(points, distances.begin(), &ComparedPoint::distance);
  common.factors.x() = median(distances);
  constexpr std::size_t fewest = 100;
  if (points.size() < fewest) return common;

  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round) {
    // 2. Points within three standard deviations, which follow from the median deviation.
    std::ranges::transform(points, distances.begin(), [&](const ComparedPoint& point) {
      return std::abs(point.distance - common.factors.dot(point.terms));
    });
    const double largest = 3 * 1.4826 * median(distances);

    Eigen::Matrix<double, 6, 6> normal = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    CommonDistance::Terms right = CommonDistance::Terms::Zero();
    for (const auto& [terms, distance, sigma] : points) {
      if (std::abs(distance - common.factors.dot(terms)) > largest) continue;
      normal += terms * terms.transpose();
      right += distance * terms;
    }

    // 3. The function that fits them best.
    common.factors = normal.ldlt().solve(right);
  }
  return common;
}

/// Marks points off their epipolar lines as doubtful.
void reject_doubtful(Cloud& cloud, const Image<float>& off, const Image<float>& sigma,
                     const CommonDistance& common, double calibration_rms, EpipolarCheck& check) {
  const double least = std::max(least_limit, 2 * calibration_rms);
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    ++check.points;

    // The distance is NaN where the lens model does not reach a wrong coordinate: too far, too.
    const double limit = std::max(least, 5.0 * sigma(column, row));
    const double own = off(column, row) - common.at(column, row);
    if (sigma(column, row) == 0 || std::abs(own) <= limit) return;

    ++check.doubted;
    cloud.reject(column, row, Validity::doubtful_order);
  });
}

/// Medians over the points, before any is rejected.
EpipolarCheck summary_of(const std::vector<ComparedPoint>& points) {
  if (points.empty()) return {};

  std::vector<double> distances, lengths, sigmas;
  for (const ComparedPoint& point : points) {
    distances.push_back(point.distance);
    lengths.push_back(std::abs(point.distance));
    sigmas.push_back(point.sigma);
  }
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

double EpipolarCheck::doubted_share() const {
  return points == 0 ? 0 : static_cast<double>(doubted) / static_cast<double>(points);
}

double EpipolarCheck::most_common(double calibration_rms) const {
  return std::max({least_limit, 3 * median_sigma, 2 * calibration_rms});
}

bool EpipolarCheck::is_off(double calibration_rms) const {
  return common > most_common(calibration_rms);
}

bool EpipolarCheck::contradicts(double calibration_rms) const {
  constexpr double of_a_moved_rig = 3;  // projector pixels
  return doubted_share() > most_doubted || common > std::max(of_a_moved_rig, 5 * calibration_rms);
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

  // 4. The part of the distances that the calibration explains.
  const std::vector<ComparedPoint> points = compared_points(off, sigma, cloud);
  const CommonDistance common = common_distance(points, size);
  EpipolarCheck check = summary_of(points);
  if (!points.empty()) {
    constexpr double most_share = 0.9;
    std::vector<double> lengths(points.size());
    std::ranges::transform(points, lengths.begin(), [&](const ComparedPoint& point) {
      return std::abs(common.factors.dot(point.terms));
    });
    check.common = quantile(lengths, most_share);
  }

  // 5. Judge each point by the rest of its distance.
  reject_doubtful(cloud, off, sigma, common, setup.scanner.calibration_rms, check);
  maps.epipolar_distance = std::move(off);
  return check;
}

}  // namespace slipstream
