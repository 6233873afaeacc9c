#include "slipstream/calibrate/print_shape.h"

#include <cmath>

#include <Eigen/LU>
#include <Eigen/QR>

namespace slipstream {
namespace {

/// Least squares of A x = b: x and its standard deviations by what is left.
struct Fitted {
  Eigen::VectorXd values, deviations;
};

Fitted fitted(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Fitted fit{A.colPivHouseholderQr().solve(b), {}};
  const double variance = (A * fit.values - b).squaredNorm() /
                          static_cast<double>(std::max<Eigen::Index>(1, A.rows() - A.cols()));
  fit.deviations = ((A.transpose() * A).inverse().diagonal() * variance).cwiseSqrt();
  return fit;
}

}  // namespace

PrintShape print_shape(const std::vector<Eigen::Vector3d>& places,
                       const std::vector<Eigen::Vector3d>& printed) {
  const auto count = static_cast<Eigen::Index>(printed.size());
  const Eigen::Map<const Eigen::Matrix3Xd> is(places.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> ought(printed.front().data(), 3, count);
  const Eigen::Vector3d least = ought.rowwise().minCoeff(), most = ought.rowwise().maxCoeff();
  const Eigen::ArrayXd u = (2 * ought.row(0).array() - most.x() - least.x()) / (most - least).x();
  const Eigen::ArrayXd v = (2 * ought.row(1).array() - most.y() - least.y()) / (most - least).y();
  Eigen::MatrixXd terms(count, 6);
  terms << Eigen::VectorXd::Ones(count), u, v, u * u, u * v, v * v;

  PrintShape shape{.size = (most - least).norm()};
  const Fitted heights = fitted(terms, is.row(2).transpose());
  for (const Eigen::Index term : {3, 4, 5}) {
    if (std::abs(heights.values[term]) < shape.bend) continue;
    shape.bend = std::abs(heights.values[term]);
    shape.bend_deviation = heights.deviations[term];
  }
  const Fitted across = fitted(terms.leftCols<3>(), is.row(0).transpose());
  const Fitted down = fitted(terms.leftCols<3>(), is.row(1).transpose());
  const double wide = (most - least).x() / 2, high = (most - least).y() / 2;
  shape.stretch = down.values[2] / high / (across.values[1] / wide) - 1;
  shape.stretch_deviation = std::hypot(down.deviations[2] / high, across.deviations[1] / wide);
  return shape;
}

}  // namespace slipstream
