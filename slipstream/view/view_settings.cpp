#include "slipstream/view/view_settings.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::view {
namespace {

constexpr std::array<std::pair<PointColour, std::string_view>, 3> names{
    {{PointColour::reflectivity, "reflectivity"},
     {PointColour::modulation, "modulation"},
     {PointColour::depth, "depth"}}};

}  // namespace

PointColour point_colour_named(std::string_view name) {
  for (const auto& [colour, its_name] : names) {
    if (name == its_name) return colour;
  }
  throw Error(fmt::format("'{}' is no colour of points; reflectivity, modulation or depth", name));
}

std::vector<std::string_view> point_colour_names() {
  std::vector<std::string_view> all;
  for (const auto& [colour, its_name] : names) all.push_back(its_name);
  return all;
}

}  // namespace slipstream::view
