#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream {

/// How many characters to insert, take away or replace, at least, to turn one into the other.
inline std::size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);  // from the characters so far to each begin of `to`
  std::iota(row.begin(), row.end(), std::size_t{0});
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

/// "; did you mean pmp?" for the end of a message, of the known name that is nearest to one that is
/// not known; empty where none is near.
template <class Names>
std::string did_you_mean(std::string_view name, const Names& known) {
  std::string_view nearest;
  std::size_t least = name.size() / 3 + 2;  // so many edits are no slip of the hand
  for (const auto& candidate : known) {
    const std::string_view other = candidate;
    const bool begun = name.size() >= 3 && other.starts_with(name);
    const std::size_t distance = begun ? 1 : edit_distance(name, other);
    if (distance >= least || distance >= other.size()) continue;
    least = distance;
    nearest = other;
  }
  return nearest.empty() ? "" : "; did you mean " + std::string(nearest) + "?";
}

}  // namespace slipstream
