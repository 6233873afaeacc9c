#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "slipstream/cloud/object_model.h"
#include "slipstream/frames/pool.h"
#include "slipstream/live/bounded_queue.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_settings.h"
#include "slipstream/live/live_statistics.h"

namespace slipstream {

/// Clouds that one follower holds at a time: one that waits and one that is looked at.
inline constexpr std::size_t followed_clouds = 2;

/// Looks at clouds in a thread of its own, which nobody waits for.
class CloudFollower {
 public:
  /// `failed`: what `look` throws; then no more clouds are looked at. `places`: clouds that may
  /// wait.
  CloudFollower(std::function<void(const Pooled<LiveCloud>&)> look,
                std::function<void(std::exception_ptr)> failed, std::size_t places = 1);
  ~CloudFollower() { finish(); }
  CloudFollower(const CloudFollower&) = delete;
  CloudFollower& operator=(const CloudFollower&) = delete;

  /// In place of the oldest that waits, where there is no room: that is missed. True where one was.
  bool follow(const Pooled<LiveCloud>& cloud);
  [[nodiscard]] std::size_t waiting() const { return waiting_.waiting(); }
  /// Looks at what waits, and ends.
  void finish();

 private:
  BoundedQueue<Pooled<LiveCloud>> waiting_;
  std::thread thread_;
};

/// All that the settings want followed in the clouds of a run.
class FollowedObject {
 public:
  FollowedObject(const LiveSettings& settings, const Lens& camera,
                 const std::function<void(std::exception_ptr)>& failed);

  void follow(const Pooled<LiveCloud>& cloud);
  void finish();
  void add_to(LiveStatistics& statistics) const;
  /// Without points where no model was asked for.
  [[nodiscard]] ModelPoints model() const;

 private:
  void track(const LiveCloud& cloud);
  void take_in(const LiveCloud& cloud);

  mutable std::mutex mutex_;  ///< of what follows but for the model, which its own guards
  std::optional<ObjectTracker> tracker_;
  std::uint64_t track_missed_ = 0;
  ModelStatistics model_statistics_;
  double model_milliseconds_ = 0;
  mutable std::mutex model_mutex_;
  std::optional<ObjectModel> model_;
  std::unique_ptr<CloudFollower> track_follower_, model_follower_;
};

}  // namespace slipstream
