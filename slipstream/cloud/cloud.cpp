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
  // In vectors; a counter for each pixel waits for the one before, which most often is the same.
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto value = static_cast<Validity>(i);
    counts[i] = static_cast<std::size_t>(std::count(validity.begin(), validity.end(), value));
  }
  return counts;
}

}  // namespace slipstream
