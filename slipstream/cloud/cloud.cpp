#include "slipstream/cloud/cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

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
  return static_cast<std::uint8_t>(std::clamp(double{intensity}, 0.0, 255.0) + 0.5);
}

ValidityCounts count_by_validity(const Image<Validity>& validity) {
  // A counter waits for its last increment, and neighbours most often count the same.
  std::array<ValidityCounts, 8> of_each{};
  std::size_t next = 0;
  for (const Validity value : validity) ++of_each[next++ % 8][static_cast<std::size_t>(value)];
  ValidityCounts counts{};
  for (const ValidityCounts& one : of_each) {
    std::transform(one.begin(), one.end(), counts.begin(), counts.begin(), std::plus<>());
  }
  return counts;
}

}  // namespace slipstream
