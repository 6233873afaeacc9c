#include "slipstream/publish/publisher.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "slipstream/frames/thread_priority.h"
#include "slipstream/live/live_cloud.h"

namespace slipstream {
namespace {

std::string text_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

struct Publisher::Outlet {
  Outlet(std::string called, std::unique_ptr<CloudSink> opened)
      : name(std::move(called)),
        sink(std::move(opened)),
        follower(
            [this](const Pooled<LiveCloud>& cloud) {
              if (published == 0) let_others_go_first();
              if (follower.waiting() == 0) late = false;
              sink->put(cloud, late);
              ++published;
            },
            [this](const std::exception_ptr& failure) { fail(failure); }, waiting_clouds) {}

  void fail(const std::exception_ptr& failure) {
    const std::lock_guard lock(mutex);
    if (error.empty()) error = text_of(failure);
  }

  void finish() {
    follower.finish();
    if (std::exchange(finished, true)) return;
    try {
      sink->finish();
    } catch (...) {
      fail(std::current_exception());
    }
  }

  SinkStatistics statistics() const {
    const std::lock_guard lock(mutex);
    return {name, published, dropped, error};
  }

  const std::string name;
  std::unique_ptr<CloudSink> sink;
  std::atomic<std::uint64_t> published = 0, dropped = 0;
  std::atomic<bool> late = false;  ///< from a cloud that is dropped until none waits
  mutable std::mutex mutex;
  std::string error;
  bool finished = false, told_drops = false, told_error = false;
  CloudFollower follower;
};

Publisher::Publisher() = default;

Publisher::~Publisher() {
  finish();
}

void Publisher::add(const std::string& name, std::unique_ptr<CloudSink> sink) {
  outlets_.push_back(std::make_unique<Outlet>(name, std::move(sink)));
}

void Publisher::publish(const Pooled<LiveCloud>& cloud) {
  for (const auto& outlet : outlets_) {
    if (!outlet->sink->wants(*cloud) || !outlet->follower.follow(cloud)) continue;
    ++outlet->dropped;
    outlet->late = true;
  }
}

void Publisher::finish() {
  for (const auto& outlet : outlets_) outlet->finish();
}

std::vector<SinkStatistics> Publisher::statistics() const {
  std::vector<SinkStatistics> all;
  for (const auto& outlet : outlets_) all.push_back(outlet->statistics());
  return all;
}

void Publisher::tell(const std::function<void(const std::string&)>& say,
                     const std::function<void(const std::string&)>& warn) {
  for (const auto& outlet : outlets_) {
    const auto [name, published, dropped, error] = outlet->statistics();
    for (const std::string& line : outlet->sink->news()) say(fmt::format("{}: {}", name, line));
    if (!error.empty()) {
      if (std::exchange(outlet->told_error, true)) continue;
      warn(fmt::format("{}: {}; nothing more is published there", name, error));
    } else if (dropped > 0 && !std::exchange(outlet->told_drops, true)) {
      warn(fmt::format("{}: clouds come faster than it takes them; the oldest are dropped", name));
    }
  }
}

}  // namespace slipstream
