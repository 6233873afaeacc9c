#include "slipstream/live/cloud_follower.h"

#include <chrono>
#include <utility>

namespace slipstream {
namespace {

/// The middle of the times at which the cloud's frames were taken, by the device's clock where it
/// has one.
double seconds_of(const LiveCloud& cloud) {
  using Seconds = std::chrono::duration<double>;
  double sum = 0;
  for (const Pooled<Frame>& frame : cloud.frames) {
    const FrameStamp& stamp = frame->stamp;
    const bool has_clock = stamp.device_time.count() != 0;
    sum += Seconds(has_clock ? stamp.device_time : stamp.host_time.time_since_epoch()).count();
  }
  return sum / static_cast<double>(cloud.frames.size());
}

}  // namespace

CloudFollower::CloudFollower(std::function<void(const Pooled<LiveCloud>&)> look,
                             std::function<void(std::exception_ptr)> failed, std::size_t places)
    : waiting_(places), thread_([this, look = std::move(look), failed = std::move(failed)] {
        try {
          while (auto cloud = waiting_.pop()) look(*cloud);
        } catch (...) {
          failed(std::current_exception());
        }
      }) {}

bool CloudFollower::follow(const Pooled<LiveCloud>& cloud) {
  return waiting_.push_over_oldest(cloud).has_value();
}

void CloudFollower::finish() {
  waiting_.close();
  if (thread_.joinable()) thread_.join();
}

FollowedObject::FollowedObject(const LiveSettings& settings, const Lens& camera,
                               const std::function<void(std::exception_ptr)>& failed) {
  if (settings.track) {
    tracker_.emplace(*settings.track);
    track_follower_ = std::make_unique<CloudFollower>(
        [this](const Pooled<LiveCloud>& cloud) { track(*cloud); }, failed);
  }
  if (settings.model) {
    model_.emplace(camera);
    model_follower_ = std::make_unique<CloudFollower>(
        [this](const Pooled<LiveCloud>& cloud) { take_in(*cloud); }, failed);
  }
}

void FollowedObject::follow(const Pooled<LiveCloud>& cloud) {
  if (cloud->cloud.z.empty()) return;  // no scanner is known
  const bool track_missed = track_follower_ && track_follower_->follow(cloud);
  const bool model_missed = model_follower_ && model_follower_->follow(cloud);
  const std::lock_guard lock(mutex_);
  if (track_missed) ++track_missed_;
  if (model_missed) ++model_statistics_.missed;
}

void FollowedObject::finish() {
  if (track_follower_) track_follower_->finish();
  if (model_follower_) model_follower_->finish();
}

void FollowedObject::track(const LiveCloud& cloud) {
  ObjectTracker next = *tracker_;  // only this thread changes it
  next.look(cloud.cloud, seconds_of(cloud));
  const std::lock_guard lock(mutex_);
  tracker_ = std::move(next);
}

void FollowedObject::take_in(const LiveCloud& cloud) {
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

void FollowedObject::add_to(LiveStatistics& statistics) const {
  const std::lock_guard lock(mutex_);
  if (tracker_) {
    statistics.track = tracker_->track();
    statistics.track->missed = track_missed_;
  }
  if (model_follower_) statistics.model = model_statistics_;
}

ModelPoints FollowedObject::model() const {
  const std::lock_guard lock(model_mutex_);
  return model_ ? model_->points() : ModelPoints();
}

}  // namespace slipstream
