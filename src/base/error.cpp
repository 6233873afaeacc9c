#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "base/throw_if-inl.h"
#include "slipstream/setting.h"

namespace slipstream {

void require_in_range(bool holds, std::string_view name, double value, std::string_view range) {
  throw_if(!holds, "{} {} is out of range; {}", name, value, range);
}

void require_in_range(const Setting& setting, double value) {
  const double least = setting.least, most = setting.most;
  const bool large_enough = setting.above_least ? value > least : value >= least;
  const bool has_range = std::isfinite(least) || std::isfinite(most);
  if (!has_range || (large_enough && value <= most)) return;

  // The message has words for the range: with both ends, or only the least value.
  std::string name = setting.name;
  std::replace(name.begin(), name.end(), '_', ' ');
  const std::string unit = *setting.unit == '\0' ? "" : fmt::format(" {}", setting.unit);

  const char* const range = most < std::numeric_limits<double>::max()
                                ? (setting.above_least ? "above {}, at most {}{}" : "{} to {}{}")
                                : (setting.above_least ? "more than {0}{2}" : "{0}{2} or more");
  require_in_range(false, name, value, fmt::format(fmt::runtime(range), least, most, unit));
}

std::size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);  // distance to each prefix of `to`
  std::iota(row.begin(), row.end(), std::size_t{0});

  // Row by row of the table of distances between prefixes; `diagonal` is the entry above on the
  // left.
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }

  return row.back();
}

}  // namespace slipstream
