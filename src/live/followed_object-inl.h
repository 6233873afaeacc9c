#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>

#include "cloud/object_model.h"
#include "live/cloud_follower.h"
#include "live/object_tracker.h"
#include "slipstream/live_pipeline.h"

namespace slipstream {

/// Mean time of the cloud's frames, s, by the device's clock if it has one.
inline double seconds_of(const LiveCloud& cloud) {
  using Seconds = std::chrono::duration<double>;

  // A device's clock may begin at 0, with one of these frames.
  const bool has_clock = std::ranges::any_of(cloud.frames, [](const Pooled<Frame>& frame) {
    return frame->stamp.device_time.count() != 0;
  });

  double sum = 0;
  for (const Pooled<Frame>& frame : cloud.frames) {
    const FrameStamp& stamp = frame->stamp;
    sum += Seconds(has_clock ? stamp.device_time : stamp.host_time.time_since_epoch()).count();
  }

  return sum / static_cast<double>(cloud.frames.size());
}

/// Tracks the object and builds the model that the settings ask for, each in its own thread.
class FollowedObject {
 public:
  FollowedObject(const LiveSettings& settings, const Lens& camera,
                 const std::function<void(std::exception_ptr)>& failed) {
    if (settings.track) {
      tracker_.emplace(*settings.track);
      track_follower_.emplace([this](const Pooled<LiveCloud>& cloud) { track(*cloud); }, failed);
    }
    if (settings.model) {
      model_.emplace(camera);
      model_follower_.emplace([this](const Pooled<LiveCloud>& cloud) { take_in(*cloud); }, failed);
    }
  }

  void follow(const Pooled<LiveCloud>& cloud) {
    if (cloud->cloud.z.empty()) return;  // no scanner
    const bool track_missed = track_follower_ && track_follower_->follow(cloud);
    const bool model_missed = model_follower_ && model_follower_->follow(cloud);

    const std::lock_guard lock(mutex_);
    if (track_missed) ++track_missed_;
    if (model_missed) ++model_statistics_.missed;
  }

  void finish() {
    if (track_follower_) track_follower_->finish();
    if (model_follower_) model_follower_->finish();
  }

  void add_to(LiveStatistics& statistics) const {
    const std::lock_guard lock(mutex_);
    if (tracker_) {
      statistics.track = tracker_->track();
      statistics.track->missed = track_missed_;
    }
    if (model_follower_) statistics.model = model_statistics_;
  }

  /// No points unless a model is requested.
  [[nodiscard]] ModelPoints model() const {
    const std::lock_guard lock(model_mutex_);
    return model_ ? model_->points() : ModelPoints();
  }

 private:
  void track(const LiveCloud& cloud) {
    ObjectTracker next = *tracker_;  // only this thread changes it

    // Fit without the lock, so that queries need not wait for it.
    next.look(cloud.cloud, seconds_of(cloud));

    const std::lock_guard lock(mutex_);
    tracker_ = std::move(next);
  }

  void take_in(const LiveCloud& cloud) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();

    const std::lock_guard model_lock(model_mutex_);
    (void)model_->add(cloud.cloud, seconds_of(cloud));
    const std::chrono::duration<double, std::milli> taken = Clock::now() - start;

    const std::lock_guard lock(mutex_);
    model_milliseconds_ += taken.count();
    model_statistics_.views = model_->views();
    model_statistics_.left_out = model_->left_out();
    model_statistics_.points = model_->elements().size();
    model_statistics_.rms = model_->registration().rms;
    model_statistics_.milliseconds = model_milliseconds_ / (model_->views() + model_->left_out());
  }

  mutable std::mutex mutex_;  ///< guards the members below, except the model
  std::optional<ObjectTracker> tracker_;
  std::uint64_t track_missed_ = 0;
  ModelStatistics model_statistics_;
  double model_milliseconds_ = 0;

  mutable std::mutex model_mutex_;  ///< guards the model
  std::optional<ObjectModel> model_;

  std::optional<CloudFollower> track_follower_, model_follower_;
};

}  // namespace slipstream
