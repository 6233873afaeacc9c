#include "live/live_counters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slipstream {
namespace {

constexpr double shortest_ms = 1e-3;  // resolution limit of the histogram

}  // namespace

void LatencyHistogram::add(std::chrono::nanoseconds duration) {
  const auto ns = std::max<std::int64_t>(duration.count(), 0);
  // Steps are logarithmic, so that each is 4 % wide.
  const double decades = std::log10(std::max(static_cast<double>(ns) * 1e-6 / shortest_ms, 1.0));
  const auto step = static_cast<std::size_t>(std::ceil(decades * steps_per_decade));
  counts_[std::min(step, steps - 1)].fetch_add(1, std::memory_order_relaxed);

  if (ns > longest_.load(std::memory_order_relaxed)) longest_.store(ns, std::memory_order_relaxed);
}

Latency LatencyHistogram::latency() const {
  // A copy, since another thread may go on counting meanwhile.
  std::array<std::uint64_t, steps> counts{};
  std::copy(counts_.begin(), counts_.end(), counts.begin());
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

std::int64_t StageMeter::slot_number(Clock::time_point time) const {
  return (time - start_) / (std::chrono::nanoseconds(std::chrono::seconds(1)) / slots_per_second);
}

void StageMeter::done(Clock::time_point captured) {
  const Clock::time_point now = Clock::now();
  const std::int64_t number = slot_number(now);

  // Slots form a ring of two seconds; one with an old number is reused.
  Slot& slot = slots_[static_cast<std::size_t>(number) % slots_.size()];
  if (slot.number.load(std::memory_order_relaxed) != number) {
    slot.count.store(0, std::memory_order_relaxed);
    slot.number.store(number, std::memory_order_relaxed);
  }

  slot.count.fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  latency_.add(now - captured);
}

StageStatistics StageMeter::statistics(Clock::time_point then) const {
  const std::int64_t now = slot_number(then);
  // Slots of the last second, or all since a later start; the slot being filled does not count.
  const std::int64_t whole = std::min(now, slots_per_second);

  std::uint64_t last_second = 0;
  for (const Slot& slot : slots_) {
    const std::int64_t number = slot.number.load(std::memory_order_relaxed);
    if (number >= now - whole && number < now) {
      last_second += slot.count.load(std::memory_order_relaxed);
    }
  }

  const double rate = static_cast<double>(last_second * slots_per_second) /
                      static_cast<double>(std::max<std::int64_t>(whole, 1));

  return {.name = {}, .done = count(), .rate = rate, .latency = latency_.latency()};
}

bool SequenceWatch::look(std::uint64_t sequence) {
  // A number far back means that the source counts from the start again.
  const bool restart = begun_ && sequence + memory < expected_;
  if (!begun_ || restart) {
    lost_ += std::exchange(damaged_, 0);
    if (restart) ++restarts_;
    begun_ = true;
    expected_ = sequence + 1;
    seen_.reset().set(0);
    return true;
  }

  // A new frame: the numbers skipped are lost, and damaged frames explain some of them.
  if (sequence >= expected_) {
    const std::uint64_t gap = sequence - expected_;
    lost_ += std::max(gap, std::exchange(damaged_, 0));
    seen_ = gap + 1 < memory ? seen_ << (gap + 1) : std::bitset<memory>();
    seen_.set(0);
    expected_ = sequence + 1;
    return true;
  }

  // A late frame: it was counted as lost, unless it came before.
  const std::uint64_t back = expected_ - 1 - sequence;
  if (back >= memory || seen_.test(back)) return false;

  seen_.set(back);
  if (lost_ > 0) --lost_;
  return true;
}

void FindingLog::replace(std::vector<Finding> findings, std::uint64_t sequence) {
  // Diagnostics that the new check no longer has end here; others begin, or go on.
  for (LiveFinding& known : found_) {
    const bool found = std::ranges::any_of(
        findings, [&](const Finding& finding) { return is_same(finding, known.finding); });
    if (!known.end && !found) known.end = sequence;
  }

  for (const Finding& finding : findings) {
    const bool lasts = std::ranges::any_of(found_, [&](const LiveFinding& known) {
      return !known.end && is_same(known.finding, finding);
    });
    if (!lasts) found_.push_back({finding, sequence});
  }

  while (found_.size() > most) {
    const auto ended = std::find_if(found_.begin(), found_.end(),
                                    [](const LiveFinding& known) { return known.end.has_value(); });
    if (ended == found_.end()) break;
    found_.erase(ended);
  }

  current_ = std::move(findings);
}

}  // namespace slipstream
