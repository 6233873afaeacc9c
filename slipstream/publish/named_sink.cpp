#include "slipstream/publish/named_sink.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/error/did_you_mean.h"
#include "slipstream/error/error.h"
#include "slipstream/publish/mcap_sink.h"
#include "slipstream/publish/web_sink.h"

namespace slipstream {
namespace {

struct Kind {
  std::string_view name, form;
  void (*require)(const std::string& where);
  std::unique_ptr<CloudSink> (*open)(const std::string& where, PublishedRun run);
};

constexpr std::array kinds{
    Kind{"web", "web:[ADDRESS:]PORT",
         [](const std::string& where) { static_cast<void>(web_address_from(where)); },
         open_web_sink},
    Kind{"mcap", "mcap:FILE", require_mcap_file, open_mcap_sink},
};

/// The kind, and what stands after it.
std::pair<const Kind*, std::string> kind_of(const std::string& name) {
  const std::size_t colon = name.find(':');
  const std::string called = name.substr(0, colon);
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const Kind& known) { return known.name == called; });
  if (kind == kinds.end()) {
    std::vector<std::string_view> names;
    for (const Kind& known : kinds) names.push_back(known.name);
    throw Error(fmt::format("--publish {}: there is no such kind of sink{}; {}", name,
                            did_you_mean(called, names), sink_forms()));
  }
  const std::string where = colon == std::string::npos ? "" : name.substr(colon + 1);
  if (where.empty()) throw Error(fmt::format("--publish {}: {} is wanted", name, kind->form));
  return {&*kind, where};
}

}  // namespace

std::string sink_forms() {
  std::vector<std::string_view> forms;
  for (const Kind& kind : kinds) forms.push_back(kind.form);
  return fmt::format("{}", fmt::join(forms, ", "));
}

void require_sink(const std::string& name) {
  const auto [kind, where] = kind_of(name);
  kind->require(where);
}

std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run) {
  const auto [kind, where] = kind_of(name);
  return kind->open(where, std::move(run));
}

}  // namespace slipstream
