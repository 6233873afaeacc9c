#pragma once

#include <cstddef>
#include <vector>

namespace slipstream {

/// Number of parts of the poses that are held out in turn: one of few poses at a time, or a quarter
/// of many, to save time.
constexpr std::size_t fold_count(std::size_t poses) {
  constexpr std::size_t few = 6, parts = 4;
  return poses <= few ? poses : parts;
}

double mean_of(const std::vector<double>& values);

/// Whether `errors` exceed `best`, fold by fold, by more than the standard error and by more than
/// 0.5 %, below which a larger model is not worthwhile.
bool clearly_worse(const std::vector<double>& errors, const std::vector<double>& best);

}  // namespace slipstream
