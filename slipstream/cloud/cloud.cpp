#include "slipstream/cloud/cloud.h"

#include <limits>

namespace slipstream {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<std::string_view, validity_count> validity_names{
    "valid",       "too dark",
    "saturated",   "doubtful fringe order",
    "no point",    "outside the projector's field",
    "out of range"};

}  // namespace

std::string_view name_of(Validity validity) {
  return validity_names[static_cast<std::size_t>(validity)];
}

Cloud::Cloud(Size size)
    : x(size, nan),
      y(size, nan),
      z(size, nan),
      intensity(size),
      validity(size, Validity::no_point) {}

std::array<std::size_t, validity_count> count_by_validity(const Cloud& cloud) {
  std::array<std::size_t, validity_count> counts{};
  for (const Validity validity : cloud.validity) ++counts[static_cast<std::size_t>(validity)];
  return counts;
}

std::size_t point_count(const Cloud& cloud) {
  return count_by_validity(cloud)[static_cast<std::size_t>(Validity::valid)];
}

}  // namespace slipstream
