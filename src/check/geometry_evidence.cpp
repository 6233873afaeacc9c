#include "check/geometry_evidence.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "check/fit.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Position of a point in the projector's picture, share of the field along and across the axis.
struct FieldPlace {
  double along = 0, across = 0;
  bool in_front = false;
};

FieldPlace place_in_field(const Scanner& scanner, Axis axis, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = in_projector_frame(scanner, point);
  const Eigen::Vector3d pixel = scanner.projector.intrinsic * p / p.z();
  const double x = pixel.x() / scanner.projector.size.width;
  const double y = pixel.y() / scanner.projector.size.height;
  return axis == Axis::x ? FieldPlace{x, y, p.z() > 0} : FieldPlace{y, x, p.z() > 0};
}

/// Depth at which the ray meets the stripe with this coordinate.
double depth_of_stripe(const Scanner& scanner, Axis axis, const Eigen::Vector3d& ray,
                       double coordinate) {
  const Eigen::Matrix3d& K = scanner.projector.intrinsic;
  const double pixel = coordinate * length_along(axis, scanner.projector.size);
  // All points of the projector's frame on this stripe satisfy plane . X = 0.
  const Eigen::RowVector3d plane = K.row(axis == Axis::x ? 0 : 1) - pixel * K.row(2);
  return -plane.dot(scanner.translation) / plane.dot(scanner.rotation * ray);
}

/// Compares the points of pixels with a scanner.
class GeometryJudge {
 public:
  GeometryJudge(const CoordinateSource& source, const Scanner& scanner, Axis axis,
                const PictureTurn& turn)
      : source_(source), scanner_(scanner), axis_(axis), turn_(turn) {}

  GeometryEvidence operator()(std::span<const CoordinateSample> samples) {
    for (const CoordinateSample& sample : samples) {
      const std::optional<SeenPoint> point = point_of(sample);

      if (!point) {
        ++without_;
        continue;
      }

      compare_with_bounds(*point);
      depths_.push_back(point->z);
      if (sample.change) add_slope(*sample.change, *point);
    }

    return samples.empty() ? GeometryEvidence() : summed_up(static_cast<double>(samples.size()));
  }

 private:
  /// A pixel's point: where its ray meets the plane of its stripe.
  struct SeenPoint {
    Eigen::Vector2d pixel;
    double z;        ///< depth, mm
    FieldPlace lit;  ///< its place in the projector's field
  };

  /// nullopt if ray and stripe meet behind a device, or are parallel.
  [[nodiscard]] std::optional<SeenPoint> point_of(const CoordinateSample& sample) const {
    const Size size = scanner_.camera.size;
    const double column = sample.pixel.x(), row = sample.pixel.y();
    const Eigen::Vector2d pixel(turn_.columns ? size.width - 1 - column : column,
                                turn_.rows ? size.height - 1 - row : row);

    const Eigen::Vector3d ray = ray_through(scanner_.camera, pixel);
    const double z = depth_of_stripe(scanner_, axis_, ray, sample.coordinate);
    const FieldPlace lit = place_in_field(scanner_, axis_, z * ray);

    if (!(z > 0 && std::isfinite(z)) || !lit.in_front) return std::nullopt;
    return SeenPoint{pixel, z, lit};
  }

  /// Counts points outside the projector's light, and beyond the calibrated depths.
  void compare_with_bounds(const SeenPoint& point) {
    // Ignoring distortion may move a point this far outside the field.
    constexpr double margin = 0.05;
    const auto is_lit = [](double place) { return place >= -margin && place <= 1 + margin; };
    if (!is_lit(point.lit.across) || !is_lit(point.lit.along)) ++outside_;

    const auto& range = scanner_.calibrated_depths;
    if (!range) return;

    // Scenes exceed the boards' depths: allow this share of the range on either side.
    constexpr double further = 0.5, slightly = 0.1;
    const auto is_outside = [&](double share) {
      const double more = share * (range->farthest - range->nearest);
      return point.z < range->nearest - more || point.z > range->farthest + more;
    };
    if (is_outside(further)) ++out_of_range_;
    if (is_outside(slightly)) ++beyond_;
  }

  /// Adds the change of the coordinate to the next pixels, relative to a surface at this depth that
  /// faces the camera.
  void add_slope(const CoordinateSample::Change& change, const SeenPoint& point) {
    const auto expected = [&](const Eigen::Vector2d& step) {
      const Eigen::Vector3d beside = ray_through(scanner_.camera, point.pixel + step);
      return place_in_field(scanner_, axis_, point.z * beside).along - point.lit.along;
    };
    const Eigen::Vector2d flat(expected({turn_.columns ? -1 : 1, 0}),
                               expected({0, turn_.rows ? -1 : 1}));

    // The phase is exact, but wraps between pixels that are a good part of a period apart.
    const bool coarse = source_.periods * flat.cwiseAbs().maxCoeff() > 0.25;

    // Least squares over both directions.
    const Eigen::Vector2d& seen = coarse ? change.coordinate : change.phase;
    const double slope = seen.dot(flat) / flat.squaredNorm();
    if (!std::isfinite(slope)) return;

    // A code alone changes by whole stripes. Steps of more are an edge of a surface.
    if (source_.stripes > 0) {
      const double most =
          1.5 / source_.stripes + FitLimits::most_slope * flat.cwiseAbs().maxCoeff();
      if (seen.cwiseAbs().maxCoeff() > most) return;
    }

    slopes_.push_back(slope);
  }

  /// The mean slope of a code alone. Most of its changes are 0: between pixels of one stripe.
  void sum_up_steps(GeometryEvidence& result) const {
    const auto count = static_cast<double>(slopes_.size());
    double sum = 0, squares = 0, falling = 0, sizes = 0;

    for (const double slope : slopes_) {
      sum += slope;
      squares += slope * slope;
      sizes += std::abs(slope);
      if (slope < 0) falling -= slope;
    }

    result.slope = sum / count;
    result.slope_doubt =
        3 * std::sqrt(std::max(0.0, squares / count - result.slope * result.slope) / count);
    if (sizes > 0) result.falling = falling / sizes;
  }

  /// Shares of the pixels, with or without a point, and medians.
  GeometryEvidence summed_up(double pixels) {
    GeometryEvidence result;
    result.without_point = without_ / pixels;

    if (!depths_.empty()) {
      const auto points = static_cast<double>(depths_.size());
      result.outside = outside_ / points;
      result.out_of_range = out_of_range_ / points;
      result.beyond = beyond_ / points;
      result.median_depth = quantile(depths_, 0.5);
    }

    // The scatter of fewer says too little about their median.
    constexpr std::size_t fewest_slopes = 16;
    if (slopes_.size() < fewest_slopes) return result;
    if (source_.stripes > 0) {
      sum_up_steps(result);
      return result;
    }

    result.slope = quantile(slopes_, 0.5);

    // From here on the slopes are deviations from their median.
    for (double& slope : slopes_) slope = std::abs(slope - result.slope);

    // Standard error of the median; 1.25 is sqrt(pi / 2), for Gaussian scatter.
    const double error = 1.25 * deviation_from_median(quantile(slopes_, 0.5)) /
                         std::sqrt(static_cast<double>(slopes_.size()));
    result.slope_doubt = 3 * error;
    return result;
  }

  const CoordinateSource& source_;
  const Scanner& scanner_;
  Axis axis_;
  const PictureTurn& turn_;

  std::vector<double> depths_, slopes_;
  int without_ = 0, outside_ = 0, out_of_range_ = 0, beyond_ = 0;
};

}  // namespace

GeometryEvidence geometry_evidence(std::span<const CoordinateSample> samples,
                                   const CoordinateSource& source, const Scanner& scanner,
                                   Axis axis, const PictureTurn& turn) {
  return GeometryJudge(source, scanner, axis, turn)(samples);
}

CoordinateSource source_of(const FrameModel& model) {
  const Layout& layout = model.layout();
  if (layout.unwrapping->whole_stripes) return {.stripes = layout.code->stripes};
  return {.periods = layout.bands[model.measuring_band()].periods};
}

}  // namespace slipstream
