#include "slipstream/base/setting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

void require_in_range(const Setting& setting, double value) {
  const double least = setting.least, most = setting.most;
  const bool large_enough = setting.above_least ? value > least : value >= least;
  const bool has_range = std::isfinite(least) || std::isfinite(most);
  if (!has_range || (large_enough && value <= most)) return;
  std::string name = setting.name;
  std::replace(name.begin(), name.end(), '_', ' ');
  const std::string unit = *setting.unit == '\0' ? "" : fmt::format(" {}", setting.unit);
  const std::string range = most < std::numeric_limits<double>::max()
                                ? fmt::format("{} to {}{}", least, most, unit)
                            : setting.above_least ? fmt::format("more than {}{}", least, unit)
                                                  : fmt::format("{}{} or more", least, unit);
  throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
}

}  // namespace slipstream
