#include "geometry/height_calibration.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Cholesky>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::size_t fewest_planes = 3;

double margin(const HeightCurve& curve) {
  return 0.1 * (curve.highest - curve.lowest);
}

/// Whether height is monotonic in phase over the whole range.
bool is_valid(const HeightCurve& curve) {
  const auto [reference, slope, bend, lowest, highest] = curve;
  const bool ordered = lowest <= 0 && highest >= 0 && lowest < highest;

  // h = d / (slope + bend d) has no pole in the range if the denominator has the slope's sign at
  // both ends.
  return std::isfinite(reference) && std::isfinite(slope) && ordered &&
         (slope + bend * (lowest - margin(curve))) * slope > 0 &&
         (slope + bend * (highest + margin(curve))) * slope > 0;
}

/// At height h the phase is y = (p + q h) / (1 - r h), so y = p + q h + r h y, linear in the
/// unknowns. The reference is fitted like any plane: its noise should not affect all heights.
HeightCurve fitted_curve(const std::vector<PlanePhase>& planes, int column, int row) {
  // 1. Normal equations, with phases relative to the first plane's and their range.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  double origin = 0, low = 0, high = 0;
  for (const auto& [height, phase] : planes) {
    if (!std::isfinite(phase(column, row))) continue;

    if (count++ == 0) origin = phase(column, row);
    const double y = phase(column, row) - origin;
    low = std::min(low, y);
    high = std::max(high, y);

    const Eigen::Vector3d terms(1, height, height * y);
    normal += terms * terms.transpose();
    right += terms * y;
  }

  if (count < fewest_planes) return {};

  // 2. Solve for p, q and r. The unknowns' units differ by orders of magnitude: scale the diagonal
  //    to 1.
  const Eigen::Vector3d units = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = units.asDiagonal() * normal * units.asDiagonal();
  const Eigen::Vector3d found = units.cwiseProduct(scaled.ldlt().solve(units.cwiseProduct(right)));
  const double p = found[0], q = found[1], r = found[2];

  // 3. With d = y - p, (q + r p + r d) h = d: the reference is p, the slope q + r p, the bend r.
  const auto single = [](double number) { return static_cast<float>(number); };
  const HeightCurve curve{single(origin + p), single(q + r * p), single(r),
                          single(std::min(low - p, 0.0)), single(std::max(high - p, 0.0))};

  return is_valid(curve) ? curve : HeightCurve{};
}

double rms_error(const Image<float>& heights, double height) {
  double sum = 0, count = 0;
  for (const float found : heights) {
    if (std::isnan(found)) continue;
    sum += (found - height) * (found - height);
    ++count;
  }
  return std::sqrt(sum / count);
}

/// Drops curves that their planes contradict; three planes always fit.
Image<HeightCurve> fitted_curves(const std::vector<PlanePhase>& planes) {
  Image<HeightCurve> curves(planes.front().phase.size());
  Image<float> squares(curves.size(), HeightCurve::nan);

  // 1. Fit each pixel, and sum the squares of its errors, mm^2.
  for_each_pixel(curves.size(), [&](int column, int row) {
    const HeightCurve curve = curves(column, row) = fitted_curve(planes, column, row);
    if (std::isnan(curve.reference)) return;

    double sum = 0;
    for (const auto& [height, phase] : planes) {
      const double off = curve.height(phase(column, row)) - height;
      if (!std::isnan(off)) sum += off * off;
    }
    squares(column, row) = static_cast<float>(sum);
  });

  // 2. Drop fits six times worse than the median pixel's, 36 in squares, and off by more than a
  //    thousandth of the largest height.
  std::vector<float> known = finite_values(squares);
  if (known.empty() || planes.size() == fewest_planes) return curves;

  double largest = 0;
  for (const PlanePhase& plane : planes) largest = std::max(largest, std::abs(plane.height));
  const double most = std::max(36. * quantile(known, 0.5), 1e-6 * largest * largest);

  for (std::size_t i = 0; i < curves.pixel_count(); ++i) {
    if (squares.begin()[i] > most) curves.begin()[i] = {};
  }

  return curves;
}

std::size_t calibrated_pixels(const Image<HeightCurve>& curves) {
  const auto count = std::ranges::count_if(
      curves, [](const HeightCurve& curve) { return !std::isnan(curve.reference); });
  if (count == 0) throw Error("no pixel has a monotonic phase over three known heights");
  return count;
}

void require_one_size(Size calibrated, Size size) {
  throw_if(calibrated != size, "phase maps of {} and {}; heights require maps of one camera",
           text_of(size), text_of(calibrated));
}

}  // namespace

double HeightCurve::height(double phase) const {
  const double d = phase - reference;
  const bool inside = d >= lowest - margin(*this) && d <= highest + margin(*this);
  return inside ? d / (slope + bend * d) : nan;
}

HeightFit fit_heights(const std::vector<PlanePhase>& planes) {
  // Planes of one size, each at its own height.
  std::set<double> known;
  for (const auto& [height, phase] : planes) {
    require_one_size(planes.front().phase.size(), phase.size());
    if (std::isfinite(height)) known.insert(height);
  }

  throw_if(known.size() < std::max(planes.size(), fewest_planes) || !known.contains(0),
           "expected at least three planes at different heights, including the reference at 0");

  HeightFit fit{.curves = fitted_curves(planes)};
  fit.pixels = calibrated_pixels(fit.curves);

  for (const auto& [height, phase] : planes) {
    fit.rms.push_back(rms_error(heights(fit.curves, phase), height));
  }
  return fit;
}

Image<float> heights(const Image<HeightCurve>& curves, const Image<double>& phase) {
  require_one_size(curves.size(), phase.size());
  Image<float> found(phase.size());
  std::ranges::transform(curves, phase, found.begin(), [](const HeightCurve& curve, double at) {
    return static_cast<float>(curve.height(at));
  });
  return found;
}

void require_valid(const Image<HeightCurve>& curves) {
  calibrated_pixels(curves);
  for_each_pixel_in_order(curves.size(), [&](int column, int row) {
    const HeightCurve& curve = curves(column, row);
    throw_if(!std::isnan(curve.reference) && !is_valid(curve),
             "row {}, column {}: the values are not a valid height curve", row, column);
  });
}

}  // namespace slipstream
