#include "simulate/frame_rows.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulate/frame_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simulate/packets-inl.h"

// Plain loops over blocks of pixels, which the compiler turns into vectors of each target.
HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

using CounterTag = hn::RebindToSigned<LaneTag>;

/// Uniform in (0, 1), as uniform().
HWY_INLINE hn::Vec<LaneTag> uniform_lanes(const std::int64_t* counters) {
  const LaneTag d;
  const auto whole = hn::ConvertTo(d, hn::Load(CounterTag(), counters));
  return hn::Mul(hn::Add(whole, hn::Set(d, 0.5)), hn::Set(d, 0x1p-53));
}

void SetGaussians(std::uint64_t seed, std::uint64_t frame, std::uint64_t first, double* values) {
  alignas(64) std::int64_t one[packet_rays], other[packet_rays];  // NOLINT(*-avoid-c-arrays)
  for (int i = 0; i < packet_rays; ++i) {
    const std::uint64_t key = seed ^ mixed(frame << 40 ^ (first + i));
    const std::uint64_t next = mixed(key);
    one[i] = static_cast<std::int64_t>(next >> 11);
    other[i] = static_cast<std::int64_t>(mixed(next) >> 11);
  }

  const LaneTag d;
  for (int i = 0; i < packet_rays; i += static_cast<int>(hn::Lanes(d))) {
    const auto radius = hn::Sqrt(hn::Mul(hn::Set(d, -2.0), hn::Log(d, uniform_lanes(one + i))));
    const auto turn = hn::Cos(d, hn::Mul(hn::Set(d, two_pi), uniform_lanes(other + i)));
    hn::StoreU(hn::Mul(radius, turn), d, values + i);
  }
}

void AddNoise(const RowNoise& noise, double* light, std::size_t count) {
  const double *const sensitivity = noise.sensitivity.data(), *const offset = noise.offset.data();
  const double* const gaussians = noise.gaussians.data();
  const double constant = noise.constant, level = noise.level, of_row = noise.of_row;

  for (std::size_t i = 0; i < count; ++i) {
    const double lit = light[i] * sensitivity[i] + offset[i];
    const double variance = constant + level * std::max(lit, 0.0);
    light[i] = lit + (of_row + std::sqrt(variance) * gaussians[i]);  // (3.10)
  }
}

void AddScaled(const double* from, double weight, double* to, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] += weight * from[i];
}

/// Blurs `count` pixels, at most as many as a packet has.
void BlurBlock(const double* row, const double* const* before, const double* const* after,
               const double* deviation, int count, double* blurred) {
  constexpr double sharpest = 1e-3;
  const LaneTag d;

  // The Gaussian at distance 1, and how far it reaches.
  Lanes sigma, one;
  sigma.fill(sharpest);
  for (int i = 0; i < count; ++i) sigma[i] = std::max(deviation[i], sharpest);
  for (int i = 0; i < packet_rays; ++i) one[i] = -0.5 / (sigma[i] * sigma[i]);
  for (int i = 0; i < packet_rays; i += static_cast<int>(hn::Lanes(d))) {
    hn::Store(hn::Exp(d, hn::Load(d, one.data() + i)), d, one.data() + i);
  }
  double widest = 0;
  for (int i = 0; i < packet_rays; ++i) widest = std::max(widest, sigma[i]);

  // Its values q, q^4, q^9 and so on: each is the last times q, q^3, q^5.
  Lanes weight, ratio, sum, weights;
  weight.fill(1);
  ratio = one;
  for (int i = 0; i < count; ++i) sum[i] = row[i];
  weights.fill(1);
  for (int distance = 1; distance < 4 * widest + 1; ++distance) {
    const double *const left = before[distance - 1], *const right = after[distance - 1];
    Lanes both;
    both.fill(0);
    for (int i = 0; i < count; ++i) both[i] = left[i] + right[i];

    for (int i = 0; i < packet_rays; ++i) {
      weight[i] *= ratio[i];
      ratio[i] *= one[i] * one[i];
      const double reached = distance < 4 * sigma[i] + 1 ? weight[i] : 0;
      sum[i] += reached * both[i];
      weights[i] += 2 * reached;
    }
  }

  for (int i = 0; i < count; ++i) blurred[i] = sum[i] / weights[i];
}

HWY_INLINE void light_under(const BlurredProfiles& profiles, const Lanes& place, const Lanes& blur,
                            Lanes& light) {
  const double* const samples = profiles.samples.data();
  const double last = profiles.size - 1.0, per_step = 1 / profiles.blur_step;
  const int size = profiles.size, widest = profiles.steps - 1;

  for (int i = 0; i < packet_rays; ++i) {
    // Between the profiles with the next smaller and the next larger blur.
    const double in_steps = blur[i] * per_step;
    const int lower = std::min(static_cast<int>(in_steps), widest);
    const int upper = std::min(lower + 1, widest);
    const double steps = lower, share = (in_steps * in_steps - steps * steps) / (2 * steps + 1);

    // Between two places; without blur at one.
    const double within = std::min(std::max(place[i] - 0.5, 0.0), last);
    const int left = static_cast<int>(std::min(within, last - 1));
    const double to_right = within - left;

    const double sharp = samples[lower * size + left];
    const double sharper = sharp + to_right * (samples[lower * size + left + 1] - sharp);
    const double soft = samples[upper * size + left];
    const double softer = soft + to_right * (samples[upper * size + left + 1] - soft);
    const double exact = samples[static_cast<int>(std::min(std::max(place[i], 0.0), last))];
    light[i] = blur[i] == 0 ? exact : sharper + share * (softer - sharper);
  }
}

/// The light of `count` samples, at most as many as a packet has.
void LightOf(const BlurredProfiles& profiles, const LitSample* samples, int count, double* light) {
  Lanes place, blur, spread;
  bool spreads = false;
  for (int i = 0; i < packet_rays; ++i) {
    const LitSample& sample = samples[i < count ? i : 0];
    const double pixel = profiles.along_columns ? sample.pixel.x() : sample.pixel.y();
    place[i] = (pixel + 0.5) * profiles.places;
    blur[i] = sample.blur;
    spread[i] = sample.spread;
    spreads |= sample.spread != 0;
  }

  Lanes sharp;
  light_under(profiles, place, blur, sharp);
  if (spreads) {
    Lanes wide, soft;
    for (int i = 0; i < packet_rays; ++i) {
      wide[i] = std::sqrt(blur[i] * blur[i] + spread[i] * spread[i]);
    }
    light_under(profiles, place, wide, soft);
    for (int i = 0; i < packet_rays; ++i) sharp[i] = (sharp[i] + soft[i]) / 2;
  }

  for (int i = 0; i < count; ++i) light[i] = sharp[i];
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(SetGaussians);
HWY_EXPORT(AddNoise);
HWY_EXPORT(AddScaled);
HWY_EXPORT(BlurBlock);
HWY_EXPORT(LightOf);

namespace {

/// Calls `body(first, count)` for each block of at most a packet's number.
template <class Body>
void for_each_block(std::size_t size, const Body& body) {
  constexpr std::size_t block = packet_rays;
  for (std::size_t first = 0; first < size; first += block) {
    body(first, static_cast<int>(std::min(block, size - first)));
  }
}

}  // namespace

void set_gaussians(std::uint64_t seed, std::uint64_t frame, std::uint64_t first,
                   std::span<double> values) {
  for_each_block(values.size(), [&](std::size_t i, int count) {
    Lanes block;
    HWY_DYNAMIC_DISPATCH(SetGaussians)(mixed(seed), frame, first + i, block.data());
    std::copy_n(block.begin(), count, values.begin() + static_cast<std::ptrdiff_t>(i));
  });
}

void add_row_noise(const RowNoise& noise, std::span<double> light) {
  HWY_DYNAMIC_DISPATCH(AddNoise)(noise, light.data(), light.size());
}

void add_scaled(std::span<const double> from, double weight, double* to) {
  HWY_DYNAMIC_DISPATCH(AddScaled)(from.data(), weight, to, from.size());
}

void blur_row(const double* row, std::span<const double* const> before,
              std::span<const double* const> after, std::span<const double> deviation,
              double* blurred) {
  std::vector<const double*> left(before.size()), right(after.size());
  for_each_block(deviation.size(), [&](std::size_t i, int count) {
    for (std::size_t k = 0; k < before.size(); ++k) {
      left[k] = before[k] + i;
      right[k] = after[k] + i;
    }
    HWY_DYNAMIC_DISPATCH(BlurBlock)
    (row + i, left.data(), right.data(), deviation.data() + i, count, blurred + i);
  });
}

void light_of(const BlurredProfiles& profiles, std::span<const LitSample> samples, double* light) {
  for_each_block(samples.size(), [&](std::size_t i, int count) {
    HWY_DYNAMIC_DISPATCH(LightOf)(profiles, samples.data() + i, count, light + i);
  });
}

}  // namespace slipstream
#endif
