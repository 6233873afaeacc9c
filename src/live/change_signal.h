#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

namespace slipstream {

/// Wakes threads that wait for a change of values which other threads own. A thread reads count(),
/// then looks at the values, then waits for a change after that count: a change that comes after
/// the look is never missed. No lock is held during the look.
class ChangeSignal {
 public:
  /// Call it after the change. From any thread.
  void announce() {
    {
      const std::lock_guard lock(mutex_);
      ++count_;
    }
    changed_.notify_all();
  }

  /// Changes so far.
  [[nodiscard]] std::uint64_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }

  /// Waits until there are more changes than `seen`, or until `end`.
  void wait(std::uint64_t seen,
            const std::optional<std::chrono::steady_clock::time_point>& end = {}) const {
    std::unique_lock lock(mutex_);
    const auto is_changed = [&] { return count_ != seen; };
    if (end) {
      changed_.wait_until(lock, *end, is_changed);
    } else {
      changed_.wait(lock, is_changed);
    }
  }

 private:
  mutable std::mutex mutex_;  ///< guards the count
  mutable std::condition_variable changed_;
  std::uint64_t count_ = 0;
};

}  // namespace slipstream
