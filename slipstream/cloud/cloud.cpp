#include "slipstream/cloud/cloud.h"

#include <algorithm>
#include <cmath>

namespace slipstream {
namespace {

constexpr std::array<std::string_view, validity_count> validity_names{
    "valid",
    "too dark",
    "saturated",
    "doubtful fringe order",
    "no point",
    "outside the projector's field",
    "out of range",
    "low trust",
    "mixed pixel",
    "outlier",
    "small component",
    "outside the region",
    "moved"};

}  // namespace

std::string_view name_of(Validity validity) {
  return validity_names[static_cast<std::size_t>(validity)];
}

std::uint8_t grey_level(float intensity) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(intensity, 0.0F, 255.0F)));
}

ValidityCounts count_by_validity(const Image<Validity>& validity) {
  ValidityCounts counts{};
  for (const Validity pixel : validity) ++counts[static_cast<std::size_t>(pixel)];
  return counts;
}

}  // namespace slipstream
