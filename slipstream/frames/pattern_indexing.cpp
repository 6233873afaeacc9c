#include "slipstream/frames/pattern_indexing.h"

#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<PatternIndexing, std::string_view>, 3> names{
    {{PatternIndexing::told, "told"},
     {PatternIndexing::counted, "counted"},
     {PatternIndexing::marker, "marker"}}};

}  // namespace

PatternIndexing pattern_indexing_named(std::string_view name) {
  for (const auto& [indexing, known] : names) {
    if (known == name) return indexing;
  }
  throw Error(fmt::format("indexing '{}' is unknown; one of {}", name,
                          fmt::join(pattern_indexing_names(), ", ")));
}

std::vector<std::string_view> pattern_indexing_names() {
  std::vector<std::string_view> all;
  for (const auto& [indexing, name] : names) all.push_back(name);
  return all;
}

}  // namespace slipstream
