#include "slipstream/publish/named_sink.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"

namespace slipstream {
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
