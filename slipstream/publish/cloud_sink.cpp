#include "slipstream/publish/cloud_sink.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"

namespace slipstream {

#ifndef SLIPSTREAM_ROS2  // without Cyclone DDS
const SinkKind ros2_sink{
    "ros2", "ros2:NAMESPACE",
    [](const std::string& name) {
      throw Error("--publish ros2:" + name +
                  " needs Cyclone DDS, without which this program was built (cyclonedds-dev, "
                  "-DSLIPSTREAM_ROS2=ON)");
    },
    [](const std::string&, PublishedRun) { return std::unique_ptr<CloudSink>(); }};
#endif

namespace {

constexpr std::array kinds{&web_sink, &mcap_sink, &ros2_sink, &genicam_sink};

std::vector<std::string> each(const char* SinkKind::*what) {
  std::vector<std::string> all(kinds.size());
  std::transform(kinds.begin(), kinds.end(), all.begin(),
                 [&](const SinkKind* kind) { return kind->*what; });
  return all;
}

/// The kind, and what stands after it.
std::pair<const SinkKind&, std::string> kind_of(const std::string& name) {
  const std::size_t colon = std::min(name.find(':'), name.size());
  const std::string called = name.substr(0, colon), what = name.substr(colon);
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const SinkKind* known) { return known->name == called; });
  if (kind == kinds.end()) {
    throw Error(fmt::format("--publish {}: there is no such kind of sink{}; {}", name,
                            did_you_mean(called, each(&SinkKind::name)), sink_forms()));
  }
  if (what.size() < 2) throw Error(fmt::format("--publish {}: {} is wanted", name, (*kind)->form));
  return {**kind, what.substr(1)};
}

}  // namespace

void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value) {
  const auto setting = std::find_if(settings.begin(), settings.end(),
                                    [&](const RunSetting& known) { return known.name == name; });
  if (setting == settings.end()) {
    std::vector<std::string> names;
    std::transform(settings.begin(), settings.end(), std::back_inserter(names),
                   [](const RunSetting& known) { return known.name; });
    throw Error(fmt::format("there is no setting '{}' now{}; there are {}", name,
                            did_you_mean(name, names), fmt::join(names, ", ")));
  }
  const auto& [_, help, unit, now, choices, least, most, state] = *setting;
  if (choices.empty()) {
    const auto number = number_in<double>(value);
    if (number && *number >= least && *number <= most) return;
    throw Error(fmt::format("{} '{}': a number from {:g} to {:g}{}{} is wanted", name, value, least,
                            most, unit.empty() ? "" : " ", unit));
  }
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  throw Error(fmt::format("{} '{}': wanted is one of: {}{}", name, value, fmt::join(choices, "; "),
                          did_you_mean(value, choices)));
}

std::string sink_forms() {
  return fmt::format("{}", fmt::join(each(&SinkKind::form), ", "));
}

void require_sink(const std::string& name) {
  const auto& [kind, what] = kind_of(name);
  kind.require(what);
}

std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run) {
  const auto& [kind, what] = kind_of(name);
  return kind.open(what, std::move(run));
}

}  // namespace slipstream
