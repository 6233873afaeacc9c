#include "codes/motion_window.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <vector>

#include "base/throw_if-inl.h"
#include "slipstream/layout.h"

namespace slipstream {
namespace {

using Phasor = std::complex<double>;
using Weights = std::vector<Phasor>;

/// Multiplies the weights by (1 - x / zero), normalised to 1 at `kept`.
Weights with_zero(const Weights& weights, Phasor zero, Phasor kept) {
  Weights product(weights.size() + 1);

  for (std::size_t n = 0; n < weights.size(); ++n) {
    product[n] += weights[n] / (1.0 - kept / zero);
    product[n + 1] -= weights[n] / (zero - kept);
  }

  return product;
}

Weights phasors(const std::vector<double>& real, const std::vector<double>& imaginary) {
  Weights weights;
  for (std::size_t n = 0; n < real.size(); ++n) weights.emplace_back(real[n], imaginary[n]);
  return weights;
}

void refuse_motion_if(bool wrong) {
  throw_if(wrong,
           "motion compensation requires patterns and cues that differ by equal shifts; use pmp or "
           "pcmp");
}

/// Weights of a sum over a cycle, and the factor by which they rotate from frame to frame.
struct CycleSum {
  explicit CycleSum(const Band& band) : CycleSum(phasors(band.cosine, band.sine)) {}
  explicit CycleSum(const std::vector<double>& real)
      : CycleSum(phasors(real, std::vector<double>(real.size()))) {}

  explicit CycleSum(Weights of) : weights(std::move(of)), turn(weights[1] / weights[0]) {
    constexpr double rounding = 1e-9;

    // Each weight must be the one before it, rotated by the same angle.
    for (std::size_t n = 0; n < weights.size(); ++n) {
      const Phasor next = weights[(n + 1) % weights.size()];
      refuse_motion_if(!(std::abs(weights[n] * turn - next) < rounding));
    }
  }

  Weights weights;
  Phasor turn;
};

/// Weights of a window `extra` frames longer than a cycle. Each N frames in a row give the sum; if
/// the sinusoid of the `moving` sum moves, two more phasors appear, which rotate from row to row.
/// In its own sum one of them is the phase. A weighted sum of the rows has zeros at the others.
Weights window_of(const CycleSum& sum, const CycleSum& moving, int extra, int first) {
  // In the moving sum itself the second phasor is the phase, which must not be cancelled.
  const Phasor both[] = {sum.turn * moving.turn, sum.turn / moving.turn};
  const bool own = std::abs(both[1] - 1.0) < 1e-9;

  // 1. Weights of the rows: zeros at the phasors that motion adds; the constant part, at 1, stays.
  Weights rows{1};
  for (int k = 0; k < extra; ++k) {
    const bool alone = !own && k + 1 == extra && extra % 2 == 1;  // keeps the rows real
    rows = with_zero(rows, alone ? -1 : both[own ? 0 : k % 2], 1);
  }

  // 2. Each row is the sum over N frames, starting one frame after the row before.
  const std::size_t N = sum.weights.size();
  Weights window(N + rows.size() - 1);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t n = row; n < row + N; ++n) {
      window[n] += rows[row] * sum.weights[(n + first) % N];
    }
  }

  return window;
}

std::vector<double> parts_of(const Weights& weights, double (*part)(const Phasor&)) {
  std::vector<double> parts;
  std::ranges::transform(weights, std::back_inserter(parts), part);
  return parts;
}

Band band_in_motion(const Band& band, const CycleSum& moving, int extra, int first) {
  const Weights window = window_of(CycleSum(band), moving, extra, first);
  Band made = band;

  // The steps that the window starts with, in the order of display.
  for (std::vector<double>* const weights : {&made.cosine, &made.sine}) {
    std::rotate(weights->begin(), weights->begin() + first, weights->end());
  }
  made.cycle = step_run(made);

  // The weights of the window for C, S and the mean.
  made.cosine = parts_of(window, std::real);
  made.sine = parts_of(window, std::imag);
  made.mean = parts_of(window_of(CycleSum(band.mean), moving, extra, first), std::real);

  return made;
}

}  // namespace

Layout motion_window(const Layout& cycle, int extra, int first) {
  throw_if(extra < 0 || extra > 16, "motion {} is out of range; 0 to 16 extra frames", extra);

  // Codes, single frames and carriers have no common shift from frame to frame.
  const bool composed = !measuring_band(cycle).mirrored.empty();
  refuse_motion_if(composed || cycle.code || !cycle.single_frames.empty());
  const CycleSum moving(measuring_band(cycle));

  Layout window = cycle;
  window.frames += extra;
  for (Band& band : window.bands) band = band_in_motion(band, moving, extra, first);

  if (window.cue) {
    window.cue->weights =
        parts_of(window_of(CycleSum(cycle.cue->weights), moving, extra, first), std::real);
  }

  return window;
}

double motion_ripple(const Layout& cycle, int extra, double speed) {
  const Weights steps = CycleSum(measuring_band(cycle)).weights;
  const Band band = measuring_band(motion_window(cycle, extra));

  // Frame n is Re(conj(s_n) exp(i n speed)) up to scale, with s_n the weight of its step.
  Phasor fringe = 0, image = 0;
  for (std::size_t n = 0; n < band.mean.size(); ++n) {
    const Phasor weight(band.cosine[n], band.sine[n]), step = steps[n % steps.size()];
    const Phasor moved = std::polar(1.0, speed * static_cast<double>(n));
    fringe += weight * std::conj(step) * moved;
    image += weight * step * std::conj(moved);
  }

  // The part of opposite rotation turns the phase by at most the arc sine of its ratio.
  return std::asin(std::min(1.0, std::abs(image) / std::abs(fringe)));
}

}  // namespace slipstream
