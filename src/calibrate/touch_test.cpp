#include "calibrate/touch_test.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "base/throw_if-inl.h"

namespace slipstream {

TouchTest touch_test(std::span<const Eigen::Vector3d> points, const Eigen::Isometry3d& camera,
                     std::span<const Eigen::Isometry3d> tools, const Eigen::Vector3d& tip) {
  throw_if(points.size() != tools.size(),
           "there are {} measured points and {} touched ones; give them in the same order",
           points.size(), tools.size());
  throw_if(points.empty(), "a touch test needs at least one point");

  TouchTest test;
  const auto count = static_cast<double>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d difference = camera * points[i] - tools[i] * tip;
    throw_if(!difference.allFinite(), "point {} is not measured", i + 1);
    test.differences.push_back(difference);
    test.mean += difference / count;
    test.rms += difference.squaredNorm() / count;
    test.largest = std::max(test.largest, difference.norm());
  }
  test.rms = std::sqrt(test.rms);

  for (const Eigen::Vector3d& difference : test.differences) {
    test.standard_error += (difference - test.mean).cwiseAbs2() / ((count - 1) * count);
  }
  test.standard_error = test.standard_error.cwiseSqrt();
  return test;
}

Verdict verdict_of(const TouchTest& test, double tolerance) {
  const double off = test.mean.norm();
  const double error = test.standard_error.allFinite() ? test.standard_error.norm() : 0;
  if (off - 2 * error > tolerance) {
    return {"bad", fmt::format("Calibrate again: the camera measures points off by {}.",
                               signed_text_of(test.mean))};
  }
  if (test.largest > tolerance) {
    return {"usable", fmt::format("Usable: the mean is off by {:.3f} mm, single points by up to "
                                  "{:.3f} mm.",
                                  off, test.largest)};
  }
  return {"good", fmt::format("Good: all points are within {:.3f} mm.", test.largest)};
}

std::string signed_text_of(const Eigen::Vector3d& offset) {
  return fmt::format("{:+.3f} mm in x, {:+.3f} mm in y, {:+.3f} mm in z", offset.x(), offset.y(),
                     offset.z());
}

}  // namespace slipstream
