#include "slipstream/decode/phase_tables.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

int largest_sum(const std::array<int, 6>& weights) {
  int positive = 0;
  for (const int weight : weights) positive += std::max(weight, 0);
  return 255 * positive;
}

}  // namespace

PhaseTables::PhaseTables(int steps, const PhaseCorrection* correction) : form_(closed_form(steps)) {
  if (form_ == nullptr) {
    throw Error(fmt::format("no phase table for {} steps; there is one for 3, 4 and 6", steps));
  }
  largest_U_ = largest_sum(form_->u);
  largest_V_ = largest_sum(form_->v);
  const std::size_t rows = static_cast<std::size_t>(2 * largest_V_ + 1);
  const std::size_t columns = static_cast<std::size_t>(2 * largest_U_ + 1);
  mlut_.resize(rows * columns);
  plut_.resize(rows * columns);
  for_each_row(static_cast<int>(rows), [&](int row) {
    const int V = row - largest_V_;
    for (int U = -largest_U_; U <= largest_U_; ++U) {
      mlut_[position(U, V)] = form_->modulation(U, V);
      const double phi = form_->wrapped_phase(U, V);
      plut_[position(U, V)] = correction == nullptr ? phi : corrected_phase(*correction, phi);
    }
  });
}

}  // namespace slipstream
