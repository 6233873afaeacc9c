#include "calibrate/left_out.h"

#include <cmath>
#include <numeric>

namespace slipstream {

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

bool clearly_worse(const std::vector<double>& errors, const std::vector<double>& best) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < errors.size(); ++i) differences.push_back(errors[i] - best[i]);
  const double average = mean_of(differences);

  double squares = 0;
  for (const double difference : differences) squares += std::pow(difference - average, 2);
  const auto n = static_cast<double>(differences.size());

  constexpr double least_share = 0.005;
  return average > std::sqrt(squares / (n - 1) / n) && average > least_share * mean_of(best);
}

}  // namespace slipstream
