#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pool.h"
#include "slipstream/live/bounded_queue.h"

namespace slipstream {

/// The cloud of one window of frames, with what it was made from.
struct LiveCloud {
  Cloud cloud;               ///< empty where no scanner is known
  ValidityCounts cleaned{};  ///< how many points cleaning took, by reason
  /// The window, as PatternWindows gives it, each frame still as the camera gave it.
  std::vector<Pooled<Frame>> frames;
  int first_pattern = 0;  ///< of its first frame
  int motion = 0;         ///< frames beyond a cycle that the cloud was made of: see motion_window
  FrameStamp newest;      ///< of the frame that completed the window
};

/// Clouds that one follower holds at a time: one that waits and one that is looked at.
inline constexpr std::size_t followed_clouds = 2;

/// Looks at clouds in a thread of its own, for which the pipeline does not wait.
class CloudFollower {
 public:
  /// `failed`: gets what `look` throws; after that the follower ignores clouds. `places`: clouds
  /// that may wait.
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
  CloudFollower(const CloudFollower&) = delete;
  CloudFollower& operator=(const CloudFollower&) = delete;

  /// Queues a cloud. True if that dropped the oldest one in a full queue.
  bool follow(const Pooled<LiveCloud>& cloud) {
    return waiting_.push_over_oldest(cloud).has_value();
  }
  [[nodiscard]] std::size_t waiting() const { return waiting_.waiting(); }
  /// Looks at what waits, and ends.
  void finish() {
    waiting_.close();
    if (thread_.joinable()) thread_.join();
  }

 private:
  BoundedQueue<Pooled<LiveCloud>> waiting_;
  std::thread thread_;
};

}  // namespace slipstream
