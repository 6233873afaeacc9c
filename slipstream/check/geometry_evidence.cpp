#include "slipstream/check/geometry_evidence.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "slipstream/base/quantile.h"
#include "slipstream/base/robust.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Where a point of the camera's frame is in the projector's picture, shares of its field along and
/// across the axis.
struct FieldPlace {
  double along = 0, across = 0;
  bool in_front = false;
};

class Stripes {
 public:
  Stripes(const Scanner& scanner, Axis axis) : scanner_(scanner), axis_(axis) {}

  [[nodiscard]] FieldPlace place(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d p = in_projector_frame(scanner_, point);
    const Eigen::Vector3d pixel = scanner_.projector.intrinsic * p / p.z();
    const double x = pixel.x() / scanner_.projector.size.width;
    const double y = pixel.y() / scanner_.projector.size.height;
    return axis_ == Axis::x ? FieldPlace{x, y, p.z() > 0} : FieldPlace{y, x, p.z() > 0};
  }

  /// Depth along the ray at which it meets the stripe of that coordinate.
  [[nodiscard]] double depth(const Eigen::Vector3d& ray, double coordinate) const {
    const Eigen::Matrix3d& K = scanner_.projector.intrinsic;
    const double pixel = coordinate * length_along(axis_, scanner_.projector.size);
    const Eigen::RowVector3d plane = K.row(axis_ == Axis::x ? 0 : 1) - pixel * K.row(2);
    return -plane.dot(scanner_.translation) / plane.dot(scanner_.rotation * ray);
  }

 private:
  const Scanner& scanner_;
  Axis axis_;
};

double wrapped(double periods) {
  return periods - std::round(periods);
}

}  // namespace

GeometryEvidence geometry_evidence(const FrameModel& model, const ScanSamples& samples,
                                   const Scanner& scanner, Axis axis, const FrameOrder& order,
                                   const PictureTurn& turn) {
  // As far past the ends of the field a lens without its distortion may put a point.
  constexpr double margin = 0.05;
  // Boards stand in the middle of what is measured: this share of their depths more on either side.
  constexpr double further = 0.5;
  const Stripes stripes(scanner, axis);
  const double f = model.layout().bands[model.measuring_band()].periods;
  const std::size_t band = model.measuring_band();
  // A code alone rises by whole stripes, and most pixels are beside one of the same.
  const bool rises = model.layout().unwrapping != Unwrapping::code_alone;
  SampleReading here, next;
  std::vector<double> depths, slopes;
  int without = 0, outside = 0, out_of_range = 0;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const Eigen::Vector2d pixel(
        turn.columns ? scanner.camera.size.width - 1 - samples.column(g) : samples.column(g),
        turn.rows ? scanner.camera.size.height - 1 - samples.row(g) : samples.row(g));
    model.read(samples.levels(g, ScanSamples::middle), order, here);
    const Eigen::Vector3d ray = ray_through(scanner.camera, pixel);
    const double z = stripes.depth(ray, here.coordinate);
    const FieldPlace lit = stripes.place(z * ray);
    if (!(z > 0 && std::isfinite(z)) || !lit.in_front) {
      ++without;
      continue;
    }
    if (lit.across < -margin || lit.across > 1 + margin || lit.along < -margin ||
        lit.along > 1 + margin)
      ++outside;
    if (const auto& range = scanner.calibrated_depths) {
      const double more = further * (range->farthest - range->nearest);
      if (z < range->nearest - more || z > range->farthest + more) ++out_of_range;
    }
    depths.push_back(z);
    const bool has_next = samples.lit(g, ScanSamples::right) && samples.lit(g, ScanSamples::below);
    if (!rises || !has_next) continue;
    const auto change = [&](ScanSamples::Place place) {
      model.read(samples.levels(g, place), order, next);
      return wrapped((next.phase[band] - here.phase[band]) / (2 * pi)) / f;
    };
    const auto expected = [&](const Eigen::Vector2d& step) {
      return stripes.place(z * ray_through(scanner.camera, pixel + step)).along - lit.along;
    };
    const Eigen::Vector2d seen(change(ScanSamples::right), change(ScanSamples::below));
    const Eigen::Vector2d flat(expected({turn.columns ? -1 : 1, 0}),
                               expected({0, turn.rows ? -1 : 1}));
    const double slope = seen.dot(flat) / flat.squaredNorm();
    if (std::isfinite(slope)) slopes.push_back(slope);
  }
  GeometryEvidence result;
  if (samples.groups() == 0) return result;
  const auto n = static_cast<double>(samples.groups());
  result.without_point = without / n;
  if (!depths.empty()) {
    result.outside = outside / static_cast<double>(depths.size());
    result.out_of_range = out_of_range / static_cast<double>(depths.size());
    result.median_depth = quantile(depths, 0.5);
  }
  if (!slopes.empty()) {
    result.slope = quantile(slopes, 0.5);
    for (double& slope : slopes) slope = std::abs(slope - result.slope);
    // Of the median of values that scatter as these about their own.
    const double error = 1.25 * deviation_from_median(quantile(slopes, 0.5)) /
                         std::sqrt(static_cast<double>(slopes.size()));
    result.slope_doubt = 3 * error;
  }
  return result;
}

}  // namespace slipstream
