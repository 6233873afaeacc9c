#include "slipstream/cloud/uncertainty.h"

#include <vector>

#include "slipstream/base/quantile.h"

namespace slipstream {

double median_depth(const Uncertainty& uncertainty) {
  std::vector<float> sigma = finite_values(uncertainty.z);
  return sigma.empty() ? 0 : quantile(sigma, 0.5);
}

}  // namespace slipstream
