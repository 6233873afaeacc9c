#include "slipstream/phase_shifting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/linear_algebra.h"
#include "base/throw_if-inl.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Weights of the mean over the frames that show the sinusoid; nullopt if sinusoids remain in it.
std::optional<std::vector<double>> own_mean(const Eigen::MatrixXd& made,
                                            const ShownSinusoid& sinusoid) {
  constexpr double rounding = 1e-12;

  Eigen::VectorXd weights(made.rows());
  std::ranges::copy(sinusoid.shown, weights.begin());
  weights /= weights.sum();

  // Sinusoids that these frames do not cancel would disturb the mean.
  if ((weights.transpose() * made.rightCols(made.cols() - 1)).norm() > rounding)
    return std::nullopt;

  return std::vector<double>(weights.begin(), weights.end());
}

const std::array band_unwrappings{Unwrapping::hierarchical, Unwrapping::beats,
                                  Unwrapping::likelihood};

const Unwrapping* band_unwrapping_named(std::string_view name) {
  const auto* const found =
      std::ranges::find_if(band_unwrappings, [&](Unwrapping way) { return way->name == name; });
  return found == band_unwrappings.end() ? nullptr : found;
}

/// The margin with that unwrapping method; 0 if it is not possible.
double margin_by(Layout layout, Unwrapping way) {
  layout.unwrapping = way;
  try {
    way->require(layout, "");
  } catch (const Error&) {
    return 0;
  }
  return unwrapping_margin(layout);
}

Unwrapping safest(const Layout& layout) {
  // For a modulation of 40 grey levels and noise of sigma_w^2 = 1.6.
  constexpr double enough = 6 * 1.26 / 40;

  Unwrapping best = Unwrapping::likelihood;
  double best_margin = 0;
  // The first method with enough margin, otherwise the one with the largest.
  for (const Unwrapping way : band_unwrappings) {
    const double margin = margin_by(layout, way);
    if (margin >= enough) return way;
    if (margin > best_margin) std::tie(best, best_margin) = std::pair(way, margin);
  }

  return best;
}

/// Throws Error unless there are `least` to `most` periods.
void require_count(std::string_view name, const std::vector<double>& periods, std::size_t least,
                   std::size_t most) {
  throw_if(periods.size() < least || periods.size() > most,
           "{}: {} periods given; expected {} to {}", name, periods.size(), least, most);
}

/// How many angles, degrees, differ from all before them; 0 if one is not finite.
int different(const std::vector<double>& angles) {
  constexpr double least = 1;
  int count = 0;

  for (auto angle = angles.begin(); angle != angles.end(); ++angle) {
    if (!std::isfinite(*angle)) return 0;
    count += std::all_of(angles.begin(), angle, [&](double other) {
      return std::abs(std::remainder(*angle - other, 360)) >= least;
    });
  }

  return count;
}

constexpr int micro_steps = 3;

}  // namespace

double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y) {
  const auto& [N, f, shifts, angles] = sinusoid;
  const double turns = angles.empty() ? 1.0 * n / N : angles[n] / 360;
  return 0.5 + 0.5 * std::cos(shifted_phase(shifts, 2 * pi * f * y) - 2 * pi * turns);
}

double intensity_of(const std::vector<Sinusoid>& runs, int n, double y) {
  auto run = runs.begin();
  while (n >= run->frames()) n -= run++->frames();
  return sinusoid_intensity(*run, n, y);
}

Layout layout_of(const std::vector<Sinusoid>& runs, Unwrapping unwrapping) {
  Layout layout{.unwrapping = unwrapping};
  for (const Sinusoid& run : runs) layout.frames += run.frames();

  // The runs follow each other in the frames.
  int first = 0;
  for (const Sinusoid& run : runs) {
    layout.bands.push_back(band_of(run, layout.frames, first));
    first += run.frames();
  }

  return layout;
}

Band band_of(const Sinusoid& sinusoid, int frames, int first, double share) {
  const auto& [N, f, shifts, angles] = sinusoid;
  if (angles.empty()) return phase_shifted_band(frames, first, N, f, 1, share, shifts);

  // Given angles: weights for the sinusoid's own frames, then zeros for all others.
  Band band = fitted_bands({shown_in_frames(f, share, angles, shifts)}, "shifts").front();
  for (std::vector<double>* const weights : {&band.cosine, &band.sine, &band.mean}) {
    weights->insert(weights->begin(), first, 0);
    weights->resize(frames);
  }

  return band;
}

void require_valid(const Sinusoid& sinusoid, const char* name) {
  const int frames = sinusoid.frames();
  throw_if(frames < 3 || frames > most_steps,
           "{}: {} steps are out of range; a sinusoid takes 3 to {}", name, frames, most_steps);

  throw_if(
      !sinusoid.angles.empty() && different(sinusoid.angles) < 3,
      "{}: shifts {} are out of range; at least 3 must differ, by 1 degree or more, modulo 360",
      name, fmt::join(sinusoid.angles, ","));

  throw_if(!std::isfinite(sinusoid.frequency) || sinusoid.frequency <= 0,
           "{}: frequency {} is out of range; expected a positive number of periods", name,
           sinusoid.frequency);
}

ShownSinusoid turned(ShownSinusoid sinusoid, const Shifts& shifts) {
  for (double& angle : sinusoid.angle) angle = (shifts.backwards ? -angle : angle) - shifts.origin;
  return sinusoid;
}

double composite_intensity(const std::vector<ShownSinusoid>& sinusoids, int n, double y,
                           double across) {
  double sum = 0;

  for (const ShownSinusoid& sinusoid : sinusoids) {
    const double phi = 2 * std::numbers::pi * (sinusoid.periods * y + sinusoid.carrier * across);
    if (sinusoid.shown[n]) sum += sinusoid.share * std::cos(phi - sinusoid.angle[n]);
  }

  return 0.5 + 0.5 * sum;
}

std::vector<Band> fitted_bands(const std::vector<ShownSinusoid>& sinusoids, std::string_view name) {
  const std::size_t frames = sinusoids.front().angle.size();
  const auto count = static_cast<Eigen::Index>(sinusoids.size());

  // 1. How the frames are made: columns for the mean and for each sinusoid's cosine and sine.
  Eigen::MatrixXd made = Eigen::MatrixXd::Zero(frames, 1 + 2 * count);
  made.col(0).setOnes();
  for (Eigen::Index i = 0; i < count; ++i) {
    const ShownSinusoid& sinusoid = sinusoids[i];
    for (std::size_t n = 0; n < frames; ++n) {
      if (!sinusoid.shown[n]) continue;
      made(n, 1 + 2 * i) = std::cos(sinusoid.angle[n]);
      made(n, 2 + 2 * i) = std::sin(sinusoid.angle[n]);
    }
  }

  // 2. The weights are the pseudo-inverse.
  const auto [weights, rank] =
      least_squares(made, Eigen::MatrixXd::Identity(made.rows(), made.rows()));
  throw_if(rank < made.cols(), "{}: {} frames cannot separate {} sinusoids", name, frames, count);

  const auto row = [&](Eigen::Index i) {
    std::vector<double> values(frames);
    for (std::size_t n = 0; n < frames; ++n) {
      constexpr double fine = 1e12;  // rounds 0.999... to exactly 1
      values[n] = std::round(fine * weights(i, n)) / fine;
    }
    return values;
  };

  // 3. A band from each sinusoid.
  std::vector<Band> bands;
  for (Eigen::Index i = 0; i < count; ++i) {
    const ShownSinusoid& sinusoid = sinusoids[i];
    Band band{.periods = sinusoid.periods,
              .share = sinusoid.share,
              .cosine = row(1 + 2 * i),
              .sine = row(2 + 2 * i),
              .mean = own_mean(made, sinusoid).value_or(row(0))};

    // A mirror image belongs to the band before it.
    if (sinusoid.carrier < 0 && !bands.empty()) {
      bands.back().mirrored.push_back(std::move(band));
      continue;
    }

    // With a carrier the band's phase is the sum of both sinusoids, with twice the periods of one.
    if (sinusoid.carrier > 0) band.periods *= 2;
    band.carrier = sinusoid.carrier;
    bands.push_back(std::move(band));
  }

  return bands;
}

void DualFrequency::require_valid() const {
  slipstream::require_valid(runs()[0], "dual-frequency, high");
  slipstream::require_valid(runs()[1], "dual-frequency, low");

  throw_if(low > 1,
           "dual-frequency: low frequency {} is out of range; at most 1 period across the field",
           low);

  // Only whole multiples let both ends of the field meet.
  const double ratio = high / low;
  throw_if(ratio < 1 || std::abs(ratio - std::round(ratio)) > 1e-9,
           "dual-frequency: high frequency {} must be a whole multiple of the low one, {}", high,
           low);
}

std::vector<Sinusoid> MultiFrequency::runs() const {
  std::vector<Sinusoid> runs;
  for (std::size_t i = 0; i < periods.size(); ++i) {
    runs.push_back({steps.size() == 1 ? steps.front() : steps[i], periods[i], shifts, angles});
  }
  return runs;
}

void MultiFrequency::require_valid() const {
  require_count(name, periods, 1, 8);

  throw_if(steps.size() != 1 && steps.size() != periods.size(),
           "multi-frequency: {} steps for {} periods; expected one for all, or one for each",
           steps.size(), periods.size());

  for (const Sinusoid& run : runs()) slipstream::require_valid(run, "multi-frequency");

  throw_if(!unwrapping.empty() && band_unwrapping_named(unwrapping) == nullptr,
           "multi-frequency: unwrapping '{}' is unknown; expected hierarchical, heterodyne or "
           "number-theory",
           unwrapping);
}

Layout MultiFrequency::layout() const {
  Layout layout = layout_of(runs(), Unwrapping::none);
  const Unwrapping* const chosen = band_unwrapping_named(unwrapping);
  layout.unwrapping = chosen != nullptr ? *chosen : safest(layout);
  return layout;
}

void MicroPhaseShifting::require_valid() const {
  require_count(name, periods, 2, 64);
  for (const double f : periods) slipstream::require_valid(Sinusoid{micro_steps, f}, "micro");
}

double MicroPhaseShifting::shape(int n, double y) const {
  const int after = std::max(n - micro_steps + 1, 0);  // index of the period
  // Each further frame is the first step of its own period.
  const Sinusoid shown{micro_steps, periods[after], shifts};
  const double intensity = sinusoid_intensity(shown, after > 0 ? 0 : n, y);
  return alternating && after % 2 == 1 ? 1 - intensity : intensity;
}

Layout MicroPhaseShifting::layout() const {
  const int frames = micro_steps + static_cast<int>(periods.size()) - 1;
  Layout layout{.frames = frames,
                .bands = {band_of({micro_steps, periods.front(), shifts}, frames)},
                .unwrapping = Unwrapping::single_frames};

  // Each further period has a single frame; inverting it shifts its phase by half a period.
  for (std::size_t i = 1; i < periods.size(); ++i) {
    layout.single_frames.push_back({micro_steps + static_cast<int>(i) - 1, periods[i],
                                    shifts.origin + (alternating && i % 2 == 1 ? pi : 0)});
  }

  return layout;
}

void ModulatedPhaseShifting::require_valid() const {
  constexpr int most_carrier_steps = 16;

  require_count(name, periods, 1, 8);
  for (const double f : periods) slipstream::require_valid(Sinusoid{steps, f}, "modulated");
  slipstream::require_valid(Sinusoid{3, carrier}, "modulated, carrier");

  const int M = carrier_steps.value_or(2);
  throw_if(M < 2 || M > most_carrier_steps, "modulated: {} carrier steps are out of range; 2 to {}",
           M, most_carrier_steps);
}

std::vector<ShownSinusoid> ModulatedPhaseShifting::sinusoids() const {
  // Frames per base: M for each of N steps or, with sinusoids shown alone, N for each of two.
  const int M = carrier_steps.value_or(1), each = steps * carrier_steps.value_or(2);
  const std::size_t frames = each * periods.size();
  std::vector<ShownSinusoid> sinusoids;

  for (std::size_t base = 0; base < periods.size(); ++base) {
    for (const int side : {1, -1}) {
      ShownSinusoid sinusoid{.periods = periods[base] / 2,
                             .share = carrier_steps ? 0.5 : 1,
                             .carrier = side * carrier,
                             .angle = std::vector<double>(frames),
                             .shown = std::vector<bool>(frames)};
      // Shown alone, one sinusoid has the first N frames and its mirror image the next N.
      for (int i = 0; i < each; ++i) {
        const std::size_t frame = each * base + i;
        const int n = i / M % steps, m = i % M;
        sinusoid.angle[frame] = 2 * pi * n / steps + side * pi * m / M;
        sinusoid.shown[frame] = carrier_steps || (i < steps) == (side > 0);
      }
      sinusoids.push_back(turned(std::move(sinusoid), shifts));
    }
  }

  return sinusoids;
}

ShownSinusoid shown_in_frames(double periods, double share, const std::vector<double>& degrees,
                              const Shifts& shifts) {
  ShownSinusoid sinusoid{.periods = periods, .share = share};
  for (const double angle : degrees) {
    sinusoid.angle.push_back(angle * pi / 180);
    // NaN differs from itself: the sinusoid is not in this frame.
    sinusoid.shown.push_back(angle == angle);
  }

  return turned(std::move(sinusoid), shifts);
}

void TwoFrequency2N::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, 1.0 * steps}, "two-frequency-2n");
  throw_if(!(share > 0 && share < 1),
           "two-frequency-2n: share {} is out of range; above 0, below 1", share);
}

std::vector<ShownSinusoid> TwoFrequency2N::sinusoids() const {
  const double N = steps;
  std::vector<double> high, low;

  // Steps of an N-th of the long period, then of an N-th of the short one.
  for (int n = 0; n < 2 * steps; ++n) {
    const double moved = n < N ? n / N : (n - N) / (N * N);  // as a fraction of the long period
    low.push_back(360 * moved);
    high.push_back(360 * N * moved);
  }

  return {shown_in_frames(N, share, high, shifts), shown_in_frames(1, 1 - share, low, shifts)};
}

void TwoFrequency4N::require_valid() const {
  require_count(name, periods, 2, 8);
  for (const double f : periods) {
    slipstream::require_valid(Sinusoid{.frequency = f}, "two-frequency-4n");
  }
}

std::vector<ShownSinusoid> TwoFrequency4N::sinusoids() const {
  const std::size_t count = periods.size();
  std::vector<ShownSinusoid> sinusoids;
  // Four frames step this sinusoid by a quarter each; in all others it stands still.
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> angles(4 * count);
    for (int step = 0; step < 4; ++step) angles[4 * i + step] = 90 * step;
    sinusoids.push_back(
        shown_in_frames(periods[i], 1 / static_cast<double>(count), angles, shifts));
  }

  return sinusoids;
}

}  // namespace slipstream
