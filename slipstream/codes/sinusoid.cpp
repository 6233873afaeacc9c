#include "slipstream/codes/sinusoid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/QR>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// Weights of the mean in the frames that show the sinusoid, where no sinusoid is left in it.
std::optional<std::vector<double>> own_mean(const Eigen::MatrixXd& made,
                                            const ShownSinusoid& sinusoid) {
  constexpr double rounding = 1e-12;
  Eigen::VectorXd weights(made.rows());
  std::copy(sinusoid.shown.begin(), sinusoid.shown.end(), weights.begin());
  weights /= weights.sum();
  if ((weights.transpose() * made.rightCols(made.cols() - 1)).norm() > rounding)
    return std::nullopt;
  return std::vector<double>(weights.begin(), weights.end());
}

}  // namespace

using std::numbers::pi;

double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y) {
  const auto& [N, f, shifts] = sinusoid;
  return 0.5 + 0.5 * std::cos(shifted_phase(shifts, 2 * pi * f * y) - 2 * pi * n / N);
}

Band band_of(const Sinusoid& sinusoid, int frames, int first, double share) {
  const auto& [N, f, shifts] = sinusoid;
  return phase_shifted_band(frames, first, N, f, 1, share, shifts);
}

void require_valid(const Sinusoid& sinusoid, const char* name) {
  if (sinusoid.steps < 3 || sinusoid.steps > most_steps) {
    throw Error(fmt::format("{}: {} steps are out of range; a sinusoid takes 3 to {}", name,
                            sinusoid.steps, most_steps));
  }
  if (!std::isfinite(sinusoid.frequency) || sinusoid.frequency <= 0) {
    throw Error(fmt::format("{}: frequency {} is out of range; it is a positive number of periods",
                            name, sinusoid.frequency));
  }
}

ShownSinusoid turned(ShownSinusoid sinusoid, const Shifts& shifts) {
  for (double& angle : sinusoid.angle) angle = (shifts.backwards ? -angle : angle) - shifts.origin;
  return sinusoid;
}

double composite_intensity(const std::vector<ShownSinusoid>& sinusoids, int n, double y,
                           double across) {
  const auto frame = static_cast<std::size_t>(n);
  double sum = 0;
  for (const ShownSinusoid& sinusoid : sinusoids) {
    const double phi = 2 * std::numbers::pi * (sinusoid.periods * y + sinusoid.carrier * across);
    if (sinusoid.shown[frame]) sum += sinusoid.share * std::cos(phi - sinusoid.angle[frame]);
  }
  return 0.5 + 0.5 * sum;
}

std::vector<Band> fitted_bands(const std::vector<ShownSinusoid>& sinusoids, std::string_view name) {
  const std::size_t frames = sinusoids.front().angle.size();
  const auto count = static_cast<Eigen::Index>(sinusoids.size());
  Eigen::MatrixXd made = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(frames), 1 + 2 * count);
  made.col(0).setOnes();
  for (Eigen::Index i = 0; i < count; ++i) {
    const ShownSinusoid& sinusoid = sinusoids[static_cast<std::size_t>(i)];
    for (std::size_t n = 0; n < frames; ++n) {
      if (!sinusoid.shown[n]) continue;
      made(static_cast<Eigen::Index>(n), 1 + 2 * i) = std::cos(sinusoid.angle[n]);
      made(static_cast<Eigen::Index>(n), 2 + 2 * i) = std::sin(sinusoid.angle[n]);
    }
  }
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(made);
  if (solver.rank() < made.cols()) {
    throw Error(fmt::format("{}: {} frames do not tell {} sinusoids apart", name, frames, count));
  }
  const Eigen::MatrixXd weights = solver.pseudoInverse();
  const auto row = [&](Eigen::Index i) {
    std::vector<double> values(frames);
    for (std::size_t n = 0; n < frames; ++n) {
      constexpr double fine = 1e12;  // so that 1 is 1, and not next to it
      values[n] = std::round(fine * weights(i, static_cast<Eigen::Index>(n))) / fine;
    }
    return values;
  };
  std::vector<Band> bands;
  for (Eigen::Index i = 0; i < count; ++i) {
    const ShownSinusoid& sinusoid = sinusoids[static_cast<std::size_t>(i)];
    Band band{.periods = sinusoid.periods,
              .share = sinusoid.share,
              .cosine = row(1 + 2 * i),
              .sine = row(2 + 2 * i),
              .mean = own_mean(made, sinusoid).value_or(row(0))};
    if (sinusoid.carrier < 0 && !bands.empty()) {
      bands.back().mirrored.push_back(std::move(band));
      continue;
    }
    if (sinusoid.carrier > 0) band.periods *= 2;
    band.carrier = sinusoid.carrier;
    bands.push_back(std::move(band));
  }
  return bands;
}

}  // namespace slipstream
