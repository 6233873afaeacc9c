#include "slipstream/pattern/motion_window.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

using Phasor = std::complex<double>;
using Weights = std::vector<Phasor>;

/// The weights times (1 - x / zero), which is 1 at `kept`.
Weights with_zero(const Weights& weights, Phasor zero, Phasor kept) {
  Weights product(weights.size() + 1);
  for (std::size_t n = 0; n < weights.size(); ++n) {
    product[n] += weights[n] / (1.0 - kept / zero);
    product[n + 1] -= weights[n] / (zero - kept);
  }
  return product;
}

/// What weights each N frames in a row so that a ripple cancels: of phasors that turn by `image`
/// from one frame to the next, where those of the phase stand still.
Weights weights_of_rows(int extra, Phasor image) {
  Weights rows{1};
  for (int k = 0; k < extra; ++k) rows = with_zero(rows, image, 1);
  return rows;
}

/// The steps that are all of the layout, as phasors for each frame.
Weights steps_of(const Layout& cycle) {
  const bool of_one_band = cycle.bands.size() == 1 && !cycle.cue && !cycle.code;
  const auto run = of_one_band ? step_run(cycle.bands.front()) : std::nullopt;
  if (!run || run->steps != cycle.frames) {
    throw Error(
        "frames of things that move are weighed over several cycles of one sinusoid; take pmp");
  }
  Weights steps;
  const Band& band = cycle.bands.front();
  for (std::size_t n = 0; n < band.cosine.size(); ++n) {
    steps.emplace_back(band.cosine[n], band.sine[n]);
  }
  return steps;
}

/// How the conjugate fringe turns from each N frames in a row to the next.
Phasor image_of(const Weights& steps) {
  const Phasor step = steps[1] / steps[0];
  return step * step;
}

}  // namespace

Layout motion_window(const Layout& cycle, int extra, int first) {
  if (extra < 0 || extra > 16) {
    throw Error(fmt::format("motion {} is out of range; 0 to 16 frames more than a cycle", extra));
  }
  const Weights steps = steps_of(cycle);
  const std::size_t N = steps.size();
  Band band = cycle.bands.front();
  band.cycle = step_run(band);
  const Weights rows = weights_of_rows(extra, image_of(steps));
  // Of the mean both fringes are zeros; one more turns neither and keeps it real.
  Weights means{1};
  for (int k = 0; k < extra; ++k) means = with_zero(means, -1, 1);
  band.cosine.assign(N + rows.size() - 1, 0);
  band.sine = band.mean = band.cosine;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t n = row; n < row + N; ++n) {
      const Phasor weight = rows[row] * steps[(n + static_cast<std::size_t>(first)) % N];
      band.cosine[n] += weight.real();
      band.sine[n] += weight.imag();
      band.mean[n] += means[row].real() / static_cast<double>(N);
    }
  }
  Layout window = cycle;
  window.frames = static_cast<int>(band.mean.size());
  window.bands = {band};
  return window;
}

double motion_ripple(const Layout& cycle, int extra, double speed) {
  const Weights steps = steps_of(cycle);
  const Band band = motion_window(cycle, extra).bands.front();
  // Frame n is Re(conj(s_n) exp(i n speed)) up to scale, s_n its step.
  Phasor fringe = 0, image = 0;
  for (std::size_t n = 0; n < band.mean.size(); ++n) {
    const Phasor weight(band.cosine[n], band.sine[n]), step = steps[n % steps.size()];
    const Phasor moved = std::polar(1.0, speed * static_cast<double>(n));
    fringe += weight * std::conj(step) * moved;
    image += weight * step * std::conj(moved);
  }
  return std::asin(std::min(1.0, std::abs(image) / std::abs(fringe)));
}

}  // namespace slipstream
