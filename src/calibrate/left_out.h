#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

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

/// The jackknife's standard deviations of a result's numbers: m results, each without one of the m
/// poses, deviate from their mean by sigma^2 = (m - 1) / m * (sum of squares).
template <class Numbers>
Numbers jackknife(const std::vector<Numbers>& without_one) {
  const auto m = static_cast<double>(without_one.size());

  Numbers mean = Numbers::Zero(), squares = Numbers::Zero();
  for (const Numbers& one : without_one) mean += one / m;
  for (const Numbers& one : without_one) squares += (one - mean).cwiseAbs2();

  return ((m - 1) / m * squares).cwiseSqrt();
}

}  // namespace slipstream
