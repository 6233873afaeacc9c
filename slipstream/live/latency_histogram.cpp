#include "slipstream/live/latency_histogram.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slipstream {
namespace {

constexpr double shortest_ms = 1e-3;

}  // namespace

void LatencyHistogram::add(std::chrono::nanoseconds duration) {
  const auto ns = std::max<std::int64_t>(duration.count(), 0);
  const double decades = std::log10(std::max(static_cast<double>(ns) * 1e-6 / shortest_ms, 1.0));
  const auto step = static_cast<std::size_t>(std::ceil(decades * steps_per_decade));
  counts_[std::min(step, steps - 1)].fetch_add(1, std::memory_order_relaxed);
  if (ns > longest_.load(std::memory_order_relaxed)) {
    longest_.store(ns, std::memory_order_relaxed);
  }
}

Latency LatencyHistogram::latency() const {
  std::array<std::uint64_t, steps> counts{};
  std::transform(counts_.begin(), counts_.end(), counts.begin(),
                 [](const auto& count) { return count.load(std::memory_order_relaxed); });
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  const double longest = static_cast<double>(longest_.load(std::memory_order_relaxed)) * 1e-6;
  const auto percentile = [&](double share) {
    const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
    std::uint64_t below = 0;
    for (std::size_t step = 0; step < steps; ++step) {
      below += counts[step];
      if (below >= rank && below > 0) {
        const double decades = static_cast<double>(step) / steps_per_decade;
        return std::min(shortest_ms * std::pow(10, decades), longest);
      }
    }
    return 0.0;
  };
  return {.p50 = percentile(0.5), .p99 = percentile(0.99), .max = longest};
}

}  // namespace slipstream
