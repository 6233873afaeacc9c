#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <thread>
#include <utility>

#include "live/bounded_queue.h"
#include "slipstream/live_pipeline.h"

namespace slipstream {

/// Clouds that one follower holds: one waiting and one in use.
inline constexpr std::size_t followed_clouds = 2;

/// Processes clouds in its own thread; the pipeline does not wait for it.
class CloudFollower {
 public:
  /// `failed`: gets an exception from `look`, which ends the follower. `places`: clouds that may
  /// wait.
  CloudFollower(std::function<void(const Pooled<LiveCloud>&)> look,
                std::function<void(std::exception_ptr)> failed, std::size_t places = 1)
      : waiting_(places), thread_([this, look = std::move(look), failed = std::move(failed)] {
          try {
            while (auto cloud = waiting_.pop()) look(*cloud);
          } catch (...) {
            failed(std::current_exception());
          }
        }) {}

  ~CloudFollower() { finish(); }

  /// Queues a cloud. True if that dropped the oldest one in a full queue.
  bool follow(const Pooled<LiveCloud>& cloud) {
    return waiting_.push_over_oldest(cloud).has_value();
  }

  [[nodiscard]] std::size_t waiting() const { return waiting_.waiting(); }

  /// Processes the waiting clouds and ends the thread.
  void finish() {
    waiting_.close();
    if (thread_.joinable()) thread_.join();
  }

 private:
  BoundedQueue<Pooled<LiveCloud>> waiting_;
  std::thread thread_;
};

}  // namespace slipstream
