#include "reconstruct/epipolar.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "base/linear_algebra.h"
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
  throw_if(!has_coordinate(other.sequence.strategy),
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

/// Deviation of a scan's coordinate due to noise, fields: of sinusoids inversely proportional to
/// the modulation.
struct CoordinateNoise {
  double at_one_level = 0;  ///< of 255
  bool whole_stripes = false;
  double grey_level = 1;  ///< of the frames, in place of one of 255

  [[nodiscard]] double at(double modulation) const {
    return whole_stripes ? at_one_level : at_one_level * grey_level / modulation;
  }
};

CoordinateNoise coordinate_noise(const EngineSetup& setup, const Scan& other,
                                 const Sequence& sequence) {
  const Layout& layout = sequence.strategy.layout();
  const double variance = coordinate_variance(layout, 1, cue_settings(setup).noise_variance);
  return {.at_one_level = std::sqrt(variance),
          .whole_stripes = layout.unwrapping->whole_stripes,
          .grey_level = other.frames.full_scale() / 255};
}

/// Both coordinates of each pixel, held against each other.
struct ComparedAxes {
  BasicMaps<double> other;  ///< along the other axis
  Image<float> off, sigma;  ///< distance from the epipolar line, or NaN, and its deviation, pixels
  Axis axis = Axis::x;      ///< of the scan

  /// Projector coordinates of a pixel; `own`: the scan's.
  [[nodiscard]] Eigen::Vector2d place(const Maps& own, int column, int row) const {
    const double along = own.coordinate(column, row), across = other.coordinate(column, row);
    return axis == Axis::x ? Eigen::Vector2d(along, across) : Eigen::Vector2d(across, along);
  }
};

ComparedAxes compared_axes(const EngineSetup& setup, const Scan& other, const Maps& maps) {
  const Scanner& scanner = setup.scanner;
  const Size size = other.frames.size();

  // 1. The coordinate along the other axis, and which of its pixels are bright enough.
  ComparedAxes axes{.other = maps_across(setup, other),
                    .off = Image<float>(size, static_cast<float>(nan)),
                    .sigma = Image<float>(size),
                    .axis = setup.sequence.axis};
  const double least = least_modulation(setup.settings, other.frames.full_scale());
  const Image<std::uint8_t> saturated = saturation_mask(other.frames);

  // 2. The deviations of both coordinates.
  const CoordinateNoise noise = coordinate_noise(setup, other, setup.sequence);
  const CoordinateNoise other_noise = coordinate_noise(setup, other, other.sequence);
  const auto [width, height] = scanner.projector.size;

  // 3. Distances from the epipolar line and their deviations, projector pixels.
  for_each_pixel(size, [&](int column, int row) {
    const double B = maps.modulation(column, row), other_B = axes.other.modulation(column, row);
    if (!(std::min(B, other_B) >= least) || saturated(column, row) != 0) return;

    const Eigen::Vector2d place = axes.place(maps, column, row);
    const auto [distance, normal] = epipolar_distance(
        scanner, ray_through(scanner.camera, {column, row}), place.x(), place.y());
    axes.off(column, row) = static_cast<float>(distance);

    double sigma_x = noise.at(B), sigma_y = other_noise.at(other_B);
    if (axes.axis == Axis::y) std::swap(sigma_x, sigma_y);
    axes.sigma(column, row) =
        static_cast<float>(std::hypot(normal.x() * width * sigma_x, normal.y() * height * sigma_y));
  });
  return axes;
}

/// A point that is compared.
struct ComparedPoint {
  CommonDistance::Terms terms;
  double distance = 0, sigma = 0;
  int column = 0, row = 0;
};

/// Whether a pixel is compared with a guard: its coordinate counts as right, also where the user
/// wants no point.
bool is_measured(Validity validity) {
  switch (validity) {
    case Validity::valid:
    case Validity::no_point:
    case Validity::outside_field:
    case Validity::out_of_range:
    case Validity::low_trust:
    case Validity::outside_region:
      return true;
    default:
      return false;
  }
}

/// The pixels with a distance that `is_compared` takes by their validity; at most about
/// `most_compared`, evenly spread.
std::vector<ComparedPoint> compared_points(const ComparedAxes& axes, const Cloud& cloud,
                                           const auto& is_compared) {
  constexpr double most_compared = 1e5;
  const auto all =
      static_cast<double>(std::count_if(cloud.validity.begin(), cloud.validity.end(), is_compared));
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(all / most_compared))));

  const CommonDistance place{.size = cloud.size()};
  std::vector<ComparedPoint> points;
  for (int row = 0; row < cloud.size().height; row += step) {
    for (int column = 0; column < cloud.size().width; column += step) {
      const double distance = axes.off(column, row);
      if (!is_compared(cloud.validity(column, row)) || std::isnan(distance)) continue;
      points.push_back({place.terms(column, row), distance, axes.sigma(column, row), column, row});
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
    for (const auto& [terms, distance, sigma, column, row] : points) {
      if (std::abs(distance - common.factors.dot(terms)) > largest) continue;
      normal += terms * terms.transpose();
      right += distance * terms;
    }

    // 3. The function that fits them best.
    common.factors = solve_symmetric(normal, right);
  }
  return common;
}

/// The largest distance of a point from the common part that noise explains, pixels.
double largest_own(double sigma, double calibration_rms) {
  return std::max({least_limit, 2 * calibration_rms, 5.0 * sigma});
}

/// Marks points off their epipolar lines as doubtful.
void reject_doubtful(Cloud& cloud, const ComparedAxes& axes, const CommonDistance& common,
                     double calibration_rms, EpipolarCheck& check) {
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    ++check.points;

    // The distance is NaN where the lens model does not reach a wrong coordinate: too far, too.
    const double sigma = axes.sigma(column, row);
    const double own = axes.off(column, row) - common.at(column, row);
    if (sigma == 0 || std::abs(own) <= largest_own(sigma, calibration_rms)) return;

    ++check.doubted;
    cloud.reject(column, row, Validity::doubtful_order);
  });
}

/// Medians over the points, before any is rejected, and the size of their common part.
EpipolarCheck summary_of(const std::vector<ComparedPoint>& points, const CommonDistance& common) {
  if (points.empty()) return {};

  // 1. Of each point: the distance, its common part and the rest.
  std::vector<double> distances, lengths, sigmas, commons, owns;
  for (const ComparedPoint& point : points) {
    const double of_all = common.factors.dot(point.terms);
    distances.push_back(point.distance);
    lengths.push_back(std::abs(point.distance));
    sigmas.push_back(point.sigma);
    commons.push_back(std::abs(of_all));
    owns.push_back(std::abs(point.distance - of_all));
  }

  // 2. Over all points.
  constexpr double most_share = 0.9;
  const CommonDistance::Terms& factors = common.factors;
  return {.median = median(std::move(distances)),
          .median_length = median(std::move(lengths)),
          .median_sigma = median(std::move(sigmas)),
          .common = quantile(commons, most_share),
          .constant = std::abs(factors[0]),
          .linear = factors.segment<2>(1).norm(),
          .quadratic = factors.tail<3>().norm(),
          .own = median(std::move(owns))};
}

/// Up to a thousand points, evenly spread, that the common part fits.
std::vector<SeenPixel> fitting_pixels(const std::vector<ComparedPoint>& points,
                                      const CommonDistance& common, double largest,
                                      const ComparedAxes& axes, const Maps& maps) {
  constexpr std::size_t most = 1000;
  const std::size_t step = std::max<std::size_t>(1, points.size() / most);

  std::vector<SeenPixel> pixels;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const ComparedPoint& point = points[i];
    if (std::abs(point.distance - common.factors.dot(point.terms)) > largest) continue;
    const Eigen::Vector2d place = axes.place(maps, point.column, point.row);
    pixels.push_back({{point.column, point.row}, place.x(), place.y()});
  }
  return pixels;
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
  // The share of the points' own parts that their common part may be: of many points a quarter, as
  // gamma and interreflections do not quite average out; of few more, by their noise.
  const double count = std::max<double>(1, static_cast<double>(points));
  const double share = std::max(0.25, 4 / std::sqrt(count));
  return std::max({least_limit, share * own, 2 * calibration_rms});
}

bool EpipolarCheck::is_off(double calibration_rms) const {
  return common > most_common(calibration_rms);
}

bool EpipolarCheck::is_far_off(double calibration_rms) const {
  constexpr double of_a_moved_rig = 3;  // projector pixels
  return common > std::max(of_a_moved_rig, 5 * calibration_rms);
}

bool EpipolarCheck::contradicts(double calibration_rms) const {
  return doubted_share() > most_doubted || is_far_off(calibration_rms);
}

EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps,
                             Cloud& cloud) {
  // 1. Distances from the epipolar lines.
  ComparedAxes axes = compared_axes(setup, other, maps);

  // 2. The part of the distances that the calibration explains.
  const auto is_valid = [](Validity validity) { return validity == Validity::valid; };
  const std::vector<ComparedPoint> points = compared_points(axes, cloud, is_valid);
  const CommonDistance common = common_distance(points, cloud.size());
  EpipolarCheck check = summary_of(points, common);

  // 3. Judge each point by the rest of its distance.
  reject_doubtful(cloud, axes, common, setup.scanner.calibration_rms, check);
  maps.epipolar_distance = std::move(axes.off);
  return check;
}

GuardCheck check_guard(const EngineSetup& setup, const Scan& guard, const Maps& maps,
                       const Cloud& cloud) {
  // 1. Distances from the epipolar lines, and their common part.
  const ComparedAxes axes = compared_axes(setup, guard, maps);
  const std::vector<ComparedPoint> points = compared_points(axes, cloud, is_measured);
  const CommonDistance common = common_distance(points, cloud.size());

  // 2. Count the points that neither the common part nor noise explains.
  GuardCheck check{.epipolar = summary_of(points, common)};
  check.epipolar.points = points.size();
  check.measured = static_cast<std::size_t>(
      std::count_if(cloud.validity.begin(), cloud.validity.end(), is_measured));
  for (const ComparedPoint& point : points) {
    const double own = std::abs(point.distance - common.factors.dot(point.terms));
    if (own > largest_own(point.sigma, setup.scanner.calibration_rms)) ++check.epipolar.doubted;
  }

  // 3. Pixels from which to tell what moved: within three standard deviations.
  check.pixels = fitting_pixels(points, common, 3 * 1.4826 * check.epipolar.own, axes, maps);
  return check;
}

}  // namespace slipstream
