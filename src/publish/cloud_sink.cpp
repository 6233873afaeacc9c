#include "slipstream/cloud_sink.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <ranges>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/thread_priority.h"
#include "base/throw_if-inl.h"
#include "live/cloud_follower.h"
#include "publish/mcap.h"
#include "publish/sink_kind.h"

namespace slipstream {

#ifndef SLIPSTREAM_ROS2  // stub for builds without Cyclone DDS
const SinkKind ros2_sink{
    "ros2", "ros2:NAMESPACE",
    [](const std::string& name) {
      throw Error("`publish ros2:" + name +
                  "` needs Cyclone DDS, but this program was built without it (cyclonedds-dev, "
                  "-DSLIPSTREAM_ROS2=ON)");
    },
    [](const std::string&, PublishedRun) { return std::unique_ptr<CloudSink>(); }};
#endif

namespace {

constexpr std::array kinds{&web_sink, &mcap_sink, &ros2_sink, &genicam_sink, &tcp_sink};

/// The kind of sink and the text after the colon.
std::pair<const SinkKind&, std::string> kind_of(const std::string& name) {
  const std::size_t colon = std::min(name.find(':'), name.size());
  const std::string called = name.substr(0, colon), what = name.substr(colon);
  const auto kind = std::ranges::find(kinds, called, &SinkKind::name);
  throw_if(kind == kinds.end(), "`publish {}`: unknown kind of sink{}; {}", name,
           did_you_mean(called, kinds | std::views::transform(&SinkKind::name)), sink_forms());

  if (what.size() < 2) throw Error(fmt::format("`publish {}`: expected {}", name, (*kind)->form));
  return {**kind, what.substr(1)};
}

}  // namespace

void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value) {
  const auto setting = std::ranges::find(settings, name, &RunSetting::name);
  if (setting == settings.end()) {
    const auto names = settings | std::views::transform(&RunSetting::name);
    throw Error(fmt::format("there is no setting '{}' now{}; available: {}", name,
                            did_you_mean(name, names), fmt::join(names, ", ")));
  }

  // A number.
  const auto& choices = setting->choices;
  if (choices.empty()) {
    const auto number = number_in<double>(value);
    if (number && *number >= setting->least && *number <= setting->most) return;
    throw Error(fmt::format("{} '{}': expected a number from {:g} to {:g}{}{}", name, value,
                            setting->least, setting->most, setting->unit.empty() ? "" : " ",
                            setting->unit));
  }

  // A choice.
  if (std::ranges::count(choices, value) > 0) return;
  throw Error(fmt::format("{} '{}': expected one of: {}{}", name, value, fmt::join(choices, "; "),
                          did_you_mean(value, choices)));
}

std::string sink_forms() {
  return fmt::format("{}", fmt::join(kinds | std::views::transform(&SinkKind::form), ", "));
}

void require_sink(const std::string& name) {
  const auto& [kind, what] = kind_of(name);
  kind.require(what);
}

std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run) {
  const auto& [kind, what] = kind_of(name);
  return kind.open(what, std::move(run));
}

std::vector<std::string> CloudSink::news() {
  const std::lock_guard lock(news_mutex_);
  return std::exchange(news_, {});
}

void CloudSink::tell(const std::string& line) {
  const std::lock_guard lock(news_mutex_);
  if (reported_.size() < 64 && reported_.insert(line).second) news_.push_back(line);
}

struct Publisher::Outlet {
  Outlet(std::string called, std::unique_ptr<CloudSink> opened)
      : name(std::move(called)),
        sink(std::move(opened)),
        follower(
            [this](const Pooled<LiveCloud>& cloud) {
              // At the first cloud, since it concerns this thread.
              if (published == 0) let_others_go_first();
              if (follower.waiting() == 0) late = false;
              sink->put(cloud, late);
              ++published;
            },
            [this](const std::exception_ptr& failure) { fail(failure); }, waiting_clouds) {}

  void fail(const std::exception_ptr& failure) try {
    std::rethrow_exception(failure);
  } catch (const std::exception& thrown) {
    const std::lock_guard lock(mutex);
    if (error.empty()) error = thrown.what();
  }

  void finish() try {
    follower.finish();
    if (!std::exchange(finished, true)) sink->finish();
  } catch (...) {
    fail(std::current_exception());
  }

  SinkStatistics statistics() const {
    const std::lock_guard lock(mutex);
    return {name, published, dropped, error};
  }

  const std::string name;
  std::unique_ptr<CloudSink> sink;
  std::atomic<std::uint64_t> published = 0, dropped = 0;
  std::atomic<bool> late = false;  ///< from a dropped cloud until the queue is empty
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
      warn(fmt::format("{}: {}; publishing there has stopped", name, error));
    } else if (dropped > 0 && !std::exchange(outlet->told_drops, true)) {
      warn(fmt::format("{}: too slow for the clouds' rate; the oldest clouds are dropped", name));
    }
  }
}

}  // namespace slipstream
