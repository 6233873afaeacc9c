#include "response/correction.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <numbers>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Dense>

#include "base/throw_if-inl.h"
#include "decode/phase_decoder.h"
#include "response/harmonics.h"

namespace slipstream {
namespace {

using std::numbers::pi;

using Complex = std::complex<double>;

/// The root of an increasing function in [low, high], with f(low) <= 0 <= f(high), to rounding:
/// false position, with the value of the retained end halved (Illinois) and occasional bisection.
template <class Function>
double root_between(const Function& f, double low, double high) {
  constexpr double rounding = 4e-15;  // of f
  double f_low = f(low), f_high = f(high);

  if (f_low >= 0) return low;
  if (f_high <= 0) return high;

  // Which end the previous iteration replaced: two in a row halve the value at the other end.
  bool moved_low = false, moved_high = false;
  for (int i = 1; i < 200 && high - low > 1e-15; ++i) {
    // Where the straight line through both ends is zero; every eighth time, the middle.
    double place = low - f_low * (high - low) / (f_high - f_low);
    if (i % 8 == 0 || !(place > low && place < high)) place = std::midpoint(low, high);
    if (place == low || place == high) break;

    const double value = f(place);
    if (std::abs(value) < rounding) return place;

    if (value < 0) {
      low = place;
      f_low = value;
      if (std::exchange(moved_low, true)) f_high /= 2;
      moved_high = false;
    } else {
      high = place;
      f_high = value;
      if (std::exchange(moved_high, true)) f_low /= 2;
      moved_low = false;
    }
  }

  return std::midpoint(low, high);
}

double added_at(const Response& response, int steps, double place) {
  const double measured = 2 * pi * place / steps;
  return true_phase(response, steps, measured) - measured;
}

/// The matrix 1, cos, sin with a row per frame whose pseudo-inverse the band's weights of least
/// squares are: its own pseudo-inverse. Rows outside the band's frames are 0.
Eigen::MatrixX3d frames_of(const Band& band) {
  Eigen::Matrix3Xd weights(3, std::ssize(band.mean));

  for (int row = 0; const auto* const part : {&band.mean, &band.cosine, &band.sine}) {
    std::copy(part->begin(), part->end(), weights.row(row++).begin());
  }

  return weights.transpose() * (weights * weights.transpose()).inverse();
}

/// Whether each row has an angle, or is constant light alone: not so with other weights.
bool has_angles(const Eigen::MatrixX3d& frames) {
  constexpr double rounding = 1e-6;

  const auto is_near = [](double a, double b) { return std::abs(a - b) < rounding; };
  const auto rows = frames.rowwise();
  return std::ranges::all_of(rows, [&](const auto& row) {
    const double length = row.template tail<2>().norm();
    return row.isZero() || (is_near(row[0], 1) && (is_near(length, 0) || is_near(length, 1)));
  });
}

}  // namespace

double phase_error(const Response& response, int steps, double phi) {
  return -std::arg(measured_harmonics(response, steps, phi).fundamental * std::polar(1.0, -phi));
}

double distorted_phase(const Response& response, int steps, double phi) {
  return phi - phase_error(response, steps, phi);
}

double true_phase(const Response& response, int steps, double measured) {
  return true_phase([&](double phi) { return distorted_phase(response, steps, phi); }, steps,
                    measured);
}

double true_phase(const std::function<double(double)>& distorted, int steps, double measured) {
  // Maps the measured phase to [0, pi / N], where measured and true phase agree at both ends and
  // increase together, and maps the solution back.
  const double half = pi / steps;
  const double period = std::floor(measured / half);
  const double within = measured - period * half;
  const bool mirrored = std::fmod(period, 2) != 0;
  const double target = mirrored ? half - within : within;

  const double phi = root_between([&](double trial) { return distorted(trial) - target; }, 0, half);
  return period * half + (mirrored ? half - phi : phi);
}

double noise_gain(const Response& response, int steps, double phi) {
  constexpr double step = 1e-4;

  // The slope of true over measured phase, from a central difference.
  return 2 * step /
         (distorted_phase(response, steps, phi + step) -
          distorted_phase(response, steps, phi - step));
}

PhaseCorrection phase_correction(const Response& response, int steps, double accuracy) {
  throw_if(steps < 3, "{} steps are out of range; 3 or more", steps);
  if (const auto* law = std::get_if<PowerLaw>(&response)) require_gamma(law->gamma, "gamma");
  constexpr std::size_t shortest = 256, longest = 65536;

  // The first half of the period; the second is its mirror image with opposite sign.
  std::vector<double> half;
  for (std::size_t i = 0; i <= shortest / 2; ++i) {
    half.push_back(added_at(response, steps, static_cast<double>(i) / shortest));
  }

  // Doubles the table until halfway between its entries interpolation is accurate enough.
  for (std::size_t length = shortest; length < longest; length *= 2) {
    double worst = 0;
    std::vector<double> denser{half.front()};

    for (std::size_t i = 0; i + 1 < half.size(); ++i) {
      const double between =
          added_at(response, steps, (static_cast<double>(i) + 0.5) / static_cast<double>(length));
      worst = std::max(worst, std::abs(between - std::midpoint(half[i], half[i + 1])));
      denser.insert(denser.end(), {between, half[i + 1]});
    }

    if (worst <= accuracy) break;
    half = std::move(denser);
  }

  PhaseCorrection correction{steps, half};
  for (std::size_t i = half.size() - 2; i > 0; --i) correction.added.push_back(-half[i]);
  return correction;
}

std::optional<PhaseCorrection> phase_correction(const Response& response, const Band& band) {
  constexpr int count = 8192;  // of samples and entries: accurate to 1e-6 rad
  const Eigen::MatrixX3d frames = frames_of(band);
  if (!has_angles(frames) || band.share < 1 || band.carrier > 0) return std::nullopt;

  // 1. The measured phase at evenly spaced true phases.
  std::vector<double> measured;
  for (int i = 0; i <= count; ++i) {
    const double phi = 2 * pi * i / count;
    const Eigen::VectorXd sinusoid =
        frames.rightCols<2>() * Eigen::Vector2d(std::cos(phi), std::sin(phi));

    Complex sum = 0;
    for (Eigen::Index n = 0; n < sinusoid.size(); ++n) {
      sum += light_at(response, 0.5 + 0.5 * sinusoid[n]) * Complex(band.cosine[n], band.sine[n]);
    }
    measured.push_back(phi + std::arg(sum * std::polar(1.0, -phi)));

    // A phase that does not rise has no inverse.
    if (i > 0 && !(measured.back() > measured.end()[-2])) return std::nullopt;
  }

  // 2. Its inverse, by linear interpolation: the true phase at evenly spaced measured phases.
  PhaseCorrection correction{.steps = 1, .added = {}};
  for (int i = 0; i < count; ++i) {
    const double entry = 2 * pi * i / count;

    // The curve starts at phi = 0: it reaches an entry below its first phase a turn later.
    const double sought = entry + 2 * pi * std::ceil((measured.front() - entry) / (2 * pi));
    const auto after = std::upper_bound(measured.begin() + 1, measured.end() - 1, sought);
    const double part = (sought - after[-1]) / (*after - after[-1]);

    const double phi = 2 * pi / count * (static_cast<double>(after - measured.begin()) - 1 + part);
    correction.added.push_back(phi - sought);
  }

  return correction;
}

PhaseCorrections phase_corrections(const Response& response, const Layout& layout,
                                   double accuracy) {
  PhaseCorrections corrections;

  for (const int steps : step_counts(layout)) {
    if (!corrections.contains(steps))
      corrections[steps] = phase_correction(response, steps, accuracy);
  }

  // Bands without equal steps get one common correction, or none if theirs differ.
  for (const Band& band : layout.bands) {
    if (bent_run(band)) continue;

    const auto found = phase_correction(response, band);
    const bool is_shared =
        found &&
        std::ranges::equal(corrections.try_emplace(1, *found).first->second.added, found->added,
                           [](double a, double b) { return std::abs(a - b) < 1e-9; });

    if (!is_shared) {
      corrections.erase(1);
      return corrections;
    }
  }

  return corrections;
}

PatternSet precompensated(const PatternSet& patterns, const Response& response) {
  PatternSet changed = patterns;
  changed.light = {.alpha_p = 255, .beta_p = 0};

  changed.shape = [patterns, response](int n, double y, double across) {
    return value_for(response, patterns.intensity(n, y, across) / 255);
  };

  return changed;
}

}  // namespace slipstream
