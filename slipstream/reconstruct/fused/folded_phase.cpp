#include "slipstream/reconstruct/fused/folded_phase.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include "slipstream/geometry/chebyshev.h"

namespace slipstream {
namespace {

constexpr double largest_error = 8e-7;  // rad
constexpr int nodes = 48;

using Values = Eigen::Matrix<double, nodes, 1>;

/// Wrapped to (-pi, pi].
double added(const PhaseCorrection& correction, double phi) {
  constexpr double two_pi = 2 * std::numbers::pi;
  const double measured = phi - two_pi * std::floor(phi / two_pi);
  return std::remainder(corrected_phase(correction, measured) - measured, two_pi);
}

/// The folded circle of N frames.
struct Fold {
  double end;      ///< T, rad
  double tangent;  ///< its tangent

  static std::optional<Fold> of(int steps) {
    using std::numbers::pi;
    if (steps == 3 || steps == 6) return Fold{pi / 3, std::numbers::sqrt3};
    if (steps == 4) return Fold{pi / 4, 1};
    return std::nullopt;
  }

  /// The phase at x.
  [[nodiscard]] double phase(double b, double x) const {
    return std::atan2(tangent * (1 - x), 2 + b + b * x);
  }
};

bool is_odd(const PhaseCorrection& correction) {
  constexpr int samples = 500;
  for (int i = 0; i < samples; ++i) {
    const double phi = 2 * std::numbers::pi * i / (samples * correction.steps);
    if (std::abs(added(correction, phi) + added(correction, -phi)) > largest_error) return false;
  }
  return true;
}

/// The Chebyshev polynomials' coefficients of the corrected phase, rad.
Values spectrum(const PhaseCorrection& correction, const Fold& fold, double b) {
  static const Eigen::Matrix<double, nodes, nodes> transform = [] {
    Eigen::Matrix<double, nodes, nodes> T;
    for (int k = 0; k < nodes; ++k) {
      for (int i = 0; i < nodes; ++i) {
        T(k, i) = (k == 0 ? 1.0 : 2.0) / nodes * std::cos(std::numbers::pi * k * (i + 0.5) / nodes);
      }
    }
    return T;
  }();
  Values values;
  for (int i = 0; i < nodes; ++i) {
    const double phi = fold.phase(b, std::cos(std::numbers::pi * (i + 0.5) / nodes));
    values(i) = phi + added(correction, phi);
  }
  return transform * values;
}

/// The least that leaves out less than the error allowed.
int degree_of(const Values& spectrum) {
  double left_out = 0;
  for (int k = nodes - 1; k > 0; --k) {
    left_out += std::abs(spectrum(k));
    if (left_out > 0.8 * largest_error) return k;
  }
  return 0;
}

std::vector<float> in_turns(const Values& spectrum, int degree) {
  constexpr int terms = FoldedPhase::largest_degree + 1;
  Eigen::Matrix<double, terms, 1> kept = spectrum.head<terms>();
  kept.tail(terms - 1 - degree).setZero();
  const Eigen::Matrix<double, terms, 1> powers = chebyshev_coefficients<terms>().transpose() * kept;
  std::vector<float> coefficients;
  for (int k = degree; k >= 0; --k) {
    coefficients.push_back(static_cast<float>(powers(k) / (2 * std::numbers::pi)));
  }
  return coefficients;
}

/// Whether the polynomial keeps to the correction, and that to [0, T].
bool holds(const FoldedPhase& folded, const PhaseCorrection& correction, const Fold& fold) {
  constexpr int samples = 1000;
  for (int i = 0; i <= samples; ++i) {
    const double x = 2.0 * i / samples - 1, phi = fold.phase(folded.b, x);
    const double corrected = phi + added(correction, phi);
    double sum = 0;
    for (const float c : folded.coefficients) sum = sum * x + c;
    const bool close = std::abs(2 * std::numbers::pi * sum - corrected) <= largest_error;
    const bool inside = corrected >= -largest_error && corrected <= fold.end + largest_error;
    if (!close || !inside) return false;
  }
  return true;
}

}  // namespace

FoldedPhase folded_phase(const PhaseCorrection& correction) {
  const std::optional<Fold> fold = Fold::of(correction.steps);
  if (!fold || !is_odd(correction)) return {};
  FoldedPhase best;
  int least = FoldedPhase::largest_degree + 1;
  constexpr double octaves = 0.25;
  for (int i = -12; i <= 24; ++i) {
    // In float, as it will be used.
    const auto b = static_cast<float>(std::exp2(octaves * i) - 1);
    const Values terms = spectrum(correction, *fold, b);
    const int needed = degree_of(terms);
    if (needed >= least) continue;
    const FoldedPhase folded{b, in_turns(terms, needed)};
    if (!holds(folded, correction, *fold)) continue;
    least = needed;
    best = folded;
  }
  return best;
}

}  // namespace slipstream
