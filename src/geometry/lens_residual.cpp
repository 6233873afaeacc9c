#include "geometry/lens_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using Powers = std::array<double, LensResidual::largest_degree + 1>;

/// The degree of a residual with that many terms; -1 if there is none.
int degree_of(std::size_t terms) {
  for (int degree = 1; degree <= LensResidual::largest_degree; ++degree) {
    if (std::cmp_equal(residual_term_count(degree), terms)) return degree;
  }
  return -1;
}

/// T_0(x), T_1(x), ...
Powers chebyshev_values(double x, int degree) {
  Powers T{1, x};
  for (int k = 2; k <= degree; ++k) T[k] = 2 * x * T[k - 1] - T[k - 2];
  return T;
}

/// Place in the picture, -1 to 1 across it. Low degrees continue beyond the picture, where lens
/// tables need a polynomial. High ones grow fast there, so the place stops at its rim.
Eigen::Vector2d place_of(const LensResidual& residual, const Eigen::Vector2d& pixel, int degree) {
  constexpr int largest_free = 4;
  constexpr double rim = 1.1;

  const Eigen::Vector2d place = (pixel - residual.centre).cwiseQuotient(residual.half);
  if (degree <= largest_free) return place;
  return place.cwiseMax(-rim).cwiseMin(rim);
}

/// The values of all terms at a place.
Eigen::VectorXd terms_at(const Eigen::Vector2d& place, int degree) {
  const Powers x = chebyshev_values(place.x(), degree), y = chebyshev_values(place.y(), degree);

  Eigen::VectorXd terms(residual_term_count(degree));
  Eigen::Index next = 0;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) terms[next++] = x[i] * y[j];
  }
  return terms;
}

/// Coefficients of x for all terms, then those of y: sample by sample, a row of the equations.
Eigen::VectorXd row_of(const ResidualSample& sample, const LensResidual& residual, int degree) {
  const Eigen::VectorXd terms = terms_at(place_of(residual, sample.pixel, degree), degree);
  Eigen::VectorXd row(2 * terms.size());
  row << sample.along.x() * terms, sample.along.y() * terms;
  return row;
}

/// Normal equations of "no shift" at the middles of the picture's cells without samples, each as
/// heavy as a hundredth of the samples of a cell, and of small coefficients.
Eigen::MatrixXd damping(const std::vector<ResidualSample>& samples, const LensResidual& residual,
                        int degree) {
  constexpr int across = 16, down = 12;
  constexpr double share = 0.01, smallness = 1e-4;

  // 1. Which cells have samples.
  std::array<bool, across * down> has_samples{};
  for (const ResidualSample& sample : samples) {
    const Eigen::Vector2d place = (sample.pixel - residual.centre).cwiseQuotient(residual.half);
    const int column = std::clamp(static_cast<int>((place.x() + 1) / 2 * across), 0, across - 1);
    const int row = std::clamp(static_cast<int>((place.y() + 1) / 2 * down), 0, down - 1);
    has_samples[row * across + column] = true;
  }
  const auto full = static_cast<double>(std::ranges::count(has_samples, true));
  const auto count = static_cast<double>(samples.size());

  // 2. The equations of the others.
  const Eigen::Index terms = residual_term_count(degree);
  Eigen::MatrixXd none = Eigen::MatrixXd::Zero(terms, terms);
  for (int cell = 0; cell < across * down; ++cell) {
    if (has_samples[cell]) continue;
    const Eigen::Vector2d place(2 * (cell % across + 0.5) / across - 1,
                                2 * (cell / across + 0.5) / down - 1);
    const Eigen::VectorXd row = terms_at(place, degree);
    none += share * count / full * row * row.transpose();
  }
  none.diagonal().array() += smallness * count / static_cast<double>(terms);

  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(2 * terms, 2 * terms);
  both.topLeftCorner(terms, terms) = none;
  both.bottomRightCorner(terms, terms) = none;
  return both;
}

/// How far the samples are from the residual with these coefficients, pixels.
std::vector<double> distances_from(const std::vector<ResidualSample>& samples,
                                   const LensResidual& residual, int degree,
                                   const Eigen::VectorXd& factors) {
  std::vector<double> distances;
  for (const ResidualSample& sample : samples) {
    distances.push_back(std::abs(sample.off - row_of(sample, residual, degree).dot(factors)));
  }
  return distances;
}

}  // namespace

void require_valid(const LensResidual& residual, std::string_view device) {
  if (residual.terms.empty()) return;
  const bool is_finite =
      residual.centre.allFinite() && residual.half.allFinite() && residual.half.minCoeff() > 0 &&
      std::ranges::all_of(residual.terms, [](const auto& term) { return term.allFinite(); });

  throw_if(!is_finite || degree_of(residual.terms.size()) < 0,
           "{}: invalid residual map; expected 3, 6, 10, ... finite terms and a picture's size",
           device);
}

Eigen::Vector2d shift_at(const LensResidual& residual, const Eigen::Vector2d& pixel) {
  if (residual.terms.empty()) return Eigen::Vector2d::Zero();

  const int degree = degree_of(residual.terms.size());
  const Eigen::Vector2d place = place_of(residual, pixel, degree);
  const Powers x = chebyshev_values(place.x(), degree), y = chebyshev_values(place.y(), degree);

  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  std::size_t next = 0;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) shift += x[i] * y[j] * residual.terms[next++];
  }
  return shift;
}

Eigen::Vector2d shifted_by(const LensResidual& residual, const Eigen::Vector2d& ideal) {
  if (residual.terms.empty()) return ideal;
  constexpr int most_iterations = 20;
  constexpr double tolerance = 1e-12;

  // The shift hardly changes within its own length: each step gains two digits or more.
  Eigen::Vector2d pixel = ideal;
  for (int i = 0; i < most_iterations; ++i) {
    const Eigen::Vector2d next = ideal + shift_at(residual, pixel);
    const double step = (next - pixel).lpNorm<Eigen::Infinity>();
    pixel = next;
    if (!(step > tolerance)) break;
  }
  return pixel;
}

LensResidual scaled(LensResidual residual, double factor) {
  residual.centre *= factor;
  residual.half *= factor;
  for (Eigen::Vector2d& term : residual.terms) term *= factor;
  return residual;
}

LensResidual fitted_residual(const std::vector<ResidualSample>& samples, Size picture, int degree) {
  constexpr int rounds = 4;
  constexpr double deviations = 3;
  constexpr double smallest_limit = 0.02;  // pixels; no picture shows less

  LensResidual residual{.centre = {(picture.width - 1) / 2.0, (picture.height - 1) / 2.0},
                        .half = {picture.width / 2.0, picture.height / 2.0}};
  if (samples.empty()) return residual;
  const Eigen::MatrixXd held = damping(samples, residual, degree);
  const Eigen::Index terms = residual_term_count(degree);

  Eigen::VectorXd factors = Eigen::VectorXd::Zero(2 * terms);
  for (int round = 0; round < rounds; ++round) {
    // 1. How far samples may be off: the first round takes all.
    const std::vector<double> distances = distances_from(samples, residual, degree, factors);
    double largest = std::numeric_limits<double>::infinity();
    if (round > 0) {
      largest = std::max(smallest_limit, deviations * deviation_from_median(median(distances)));
    }

    // 2. Least squares of the samples that are not too far off.
    Eigen::MatrixXd normal = held;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(2 * terms);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (distances[i] > largest) continue;
      const Eigen::VectorXd row = row_of(samples[i], residual, degree);
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
      right += samples[i].off * row;
    }
    factors = solve_symmetric(normal, right);
  }

  for (Eigen::Index i = 0; i < terms; ++i) {
    residual.terms.emplace_back(factors[i], factors[terms + i]);
  }
  return residual;
}

}  // namespace slipstream
