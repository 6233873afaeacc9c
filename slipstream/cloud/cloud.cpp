#include "slipstream/cloud/cloud.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, validity_count> validity_names{
    "valid",       "too dark",
    "saturated",   "doubtful fringe order",
    "no point",    "outside the projector's field",
    "out of range",
    "low trust",
    "mixed pixel",
    "outlier",
    "small component",
    "outside the region"};

}  // namespace

std::string_view name_of(Validity validity) {
  return validity_names[static_cast<std::size_t>(validity)];
}

ValidityCounts count_by_validity(const Image<Validity>& validity) {
  ValidityCounts counts{};
  for (const Validity pixel : validity) ++counts[static_cast<std::size_t>(pixel)];
  return counts;
}

}  // namespace slipstream
