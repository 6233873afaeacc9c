#include "slipstream/strategy/phase_channel_multiplexing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/noise/predicted_variance.h"
#include "slipstream/pattern/sinusoid.h"
#include "slipstream/phase/neighbourhood_fringe_order.h"
#include "slipstream/phase/phase_channel.h"
#include "slipstream/phase/temporal_unwrapping.h"
#include "slipstream/strategy/multiplexed_cue.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// `grey_level`: a grey level of 8 bits in those of the frames.
Image<MultiplexedPixel> multiplexed_pixels(const FrameSet& frames, const PhaseMaps& maps,
                                           double grey_level) {
  const int N = frames.count();
  const Image<double> cue = N == 3   ? maps.mean
                            : N == 4 ? weighted_sum(frames, 0, half_phase_weights())
                                     : weighted_sum(frames, 0, channel_cosines(N, 2));
  const Image<double> cue_sine =
      N < 5 ? Image<double>(frames.size()) : weighted_sum(frames, 0, channel_sines(N, 2));
  Image<MultiplexedPixel> pixels(frames.size());
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    pixels.begin()[i] = {.modulation = maps.modulation.begin()[i] / grey_level,
                         .wrapped_phase = maps.wrapped_phase.begin()[i],
                         .cue = cue.begin()[i] / grey_level,
                         .cue_sine = cue_sine.begin()[i] / grey_level};
  }
  return pixels;
}

/// The fringe order of every pixel by the rule asked for.
Image<int> chosen_orders(const Image<MultiplexedPixel>& pixels, const MultiplexedCue& cue,
                         Unwrapping unwrapping, double f_h, int length) {
  Image<int> orders(pixels.size());
  std::transform(pixels.begin(), pixels.end(), orders.begin(), [&](const MultiplexedPixel& pixel) {
    switch (unwrapping) {
      case Unwrapping::published:
        return cue.published_order(pixel);
      case Unwrapping::likelihood:
        return cue.likeliest_order(pixel, length);
      case Unwrapping::consensus:
        return cue.nearest_order(pixel, length);
    }
    return 0;
  });
  if (unwrapping != Unwrapping::consensus) return orders;

  Image<double> wrapped_phase(pixels.size());
  Image<std::uint8_t> lit(pixels.size());
  std::transform(pixels.begin(), pixels.end(), wrapped_phase.begin(),
                 [](const MultiplexedPixel& pixel) { return pixel.wrapped_phase; });
  std::transform(pixels.begin(), pixels.end(), lit.begin(), [&](const MultiplexedPixel& pixel) {
    return static_cast<std::uint8_t>(cue.lit(pixel) ? 1 : 0);
  });
  const auto cost = [&](int column, int row, int order) {
    const MultiplexedPixel& pixel = pixels(column, row);
    const double y = unwrapped_coordinate(pixel.wrapped_phase, order, f_h);
    return cue.near_field(y, length) ? cue.cost(pixel, y) : std::numeric_limits<double>::infinity();
  };
  choose_with_neighbours(orders, wrapped_phase, lit, cost);
  return orders;
}

void require_monotonic(const std::function<double(double)>& reference) {
  constexpr int samples = 256;
  const double direction = reference(1) > reference(0) ? 1 : -1;
  for (int i = 0; i <= samples; ++i) {
    const double value = reference(static_cast<double>(i) / samples);
    const double next = reference(static_cast<double>(std::min(i + 1, samples)) / samples);
    if (!(std::abs(value) <= 1) || (i < samples && !(direction * (next - value) > 0))) {
      throw Error(fmt::format(
          "pcmp: the reference is {} at y = {}; it rises or falls throughout, within -1 to 1",
          value, static_cast<double>(i) / samples));
    }
  }
}

}  // namespace

double PhaseChannelMultiplexing::f_h() const {
  return high.value_or(steps == 3 ? 3 : steps == 4 ? 6 : 12);
}

double PhaseChannelMultiplexing::c1() const {
  return share.value_or(steps == 3 ? 0.5 : 0.6);
}

void PhaseChannelMultiplexing::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, f_h()}, "pcmp");
  if (f_h() < 2 || f_h() != std::floor(f_h()) || f_h() > 1e6) {
    throw Error(fmt::format(
        "pcmp: high frequency {} is out of range; a whole number of periods, 2 or more", f_h()));
  }
  if (!(c1() > 1 / f_h() && c1() < 1)) {
    throw Error(
        fmt::format("pcmp: share {} of the high frequency is out of range; above 1 / {} = {:.4g}, "
                    "where it begins to pay (Eq. 3.64), and below 1",
                    c1(), f_h(), 1 / f_h()));
  }
  if (reference && steps < 5) require_monotonic(reference);
}

double PhaseChannelMultiplexing::R(double y) const {
  const double held = std::clamp(y, 0.0, 1.0);
  if (reference) return reference(held);
  return steps == 3 ? 2 * held - 1 : std::cos(pi * held);
}

double PhaseChannelMultiplexing::inverse_R(double value) const {
  if (!reference) {
    const double held = std::clamp(value, -1.0, 1.0);
    return steps == 3 ? (held + 1) / 2 : std::acos(held) / pi;
  }
  const double direction = reference(1) > reference(0) ? 1 : -1;
  double low = 0, high_end = 1;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (low + high_end) / 2;
    (direction * (value - reference(middle)) > 0 ? low : high_end) = middle;
  }
  return (low + high_end) / 2;
}

double PhaseChannelMultiplexing::shape(int n, double y) const {
  const double N = steps;
  const double main = std::cos(2 * pi * f_h() * y - 2 * pi * n / N);
  const double cue = steps == 3   ? R(y)                                    // (3.53)
                     : steps == 4 ? (n % 2 == 0 ? R(y) : -R(y))             // (3.68)
                                  : std::cos(2 * pi * y - 4 * pi * n / N);  // (3.83)
  return 0.5 + 0.5 * c1() * main + 0.5 * c2() * cue;
}

DecodedScan PhaseChannelMultiplexing::decode(const FrameSet& frames, const PhaseDecoder& phase,
                                             int length, const CueSettings& settings) const {
  const double grey_level = frames.full_scale() / 255;
  PhaseMaps maps = phase(frames, 0, steps);
  const Image<MultiplexedPixel> pixels = multiplexed_pixels(frames, maps, grey_level);
  const MultiplexedCue cue(*this, settings);
  const bool published = settings.unwrapping == Unwrapping::published;
  const Image<int> orders = chosen_orders(pixels, cue, settings.unwrapping, f_h(), length);

  Image<double> coordinate(frames.size());
  Image<double> doubt(frames.size());
  for_each_row(frames.size().height, [&](int row) {
    for (int column = 0; column < frames.size().width; ++column) {
      const MultiplexedPixel& pixel = pixels(column, row);
      const double y = unwrapped_coordinate(pixel.wrapped_phase, orders(column, row), f_h());
      coordinate(column, row) = y;
      doubt(column, row) = cue.doubt(pixel, y);
      // In the DC channel the cue would show as a shade across the texture.
      if (!published) maps.mean(column, row) -= grey_level * cue.shade(pixel, y);
    }
  });
  return {.mean = std::move(maps.mean),
          .modulation = std::move(maps.modulation),
          .wrapped_phase = std::move(maps.wrapped_phase),
          .fringe_order_doubt = std::move(doubt),
          .coordinate = std::move(coordinate)};
}

double PhaseChannelMultiplexing::coordinate_variance(double alpha, double alpha_p,
                                                     double noise_variance) const {
  return multiplexed_coordinate_variance(steps, alpha, alpha_p, c1(), f_h(), noise_variance);
}

}  // namespace slipstream
