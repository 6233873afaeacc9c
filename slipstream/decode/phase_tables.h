#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/decode/closed_form.h"
#include "slipstream/decode/phase_correction.h"

namespace slipstream {

/// MLUT and PLUT of Liu 2010, Eqs. (2.4)-(2.18): modulation and wrapped phase of every (U, V) that
/// 3, 4 or 6 frames of 8 bits can give, in double, so that nothing is lost against the equations.
/// N = 3: 4.2 MB each; N = 4: 2.1 MB; N = 6: 16.7 MB.
class PhaseTables {
 public:
  /// Throws Error when `steps` is not 3, 4 or 6. With a correction the PLUT holds corrected phase,
  /// which costs nothing later; null: none.
  explicit PhaseTables(int steps, const PhaseCorrection* correction = nullptr);

  [[nodiscard]] const ClosedForm& form() const { return *form_; }
  /// Largest |U| and |V| that 8-bit frames reach.
  [[nodiscard]] int largest_U() const { return largest_U_; }
  [[nodiscard]] int largest_V() const { return largest_V_; }

  /// B^c in grey levels, |U| <= largest_U(), |V| <= largest_V().
  [[nodiscard]] double mlut(int U, int V) const { return mlut_[position(U, V)]; }
  /// phi in rad, [0, 2 pi), corrected where the tables were made so.
  [[nodiscard]] double plut(int U, int V) const { return plut_[position(U, V)]; }

 private:
  [[nodiscard]] std::size_t position(int U, int V) const {
    const int row = V + largest_V_, column = U + largest_U_;
    const int entry = row * (2 * largest_U_ + 1) + column;
    return static_cast<std::size_t>(entry);
  }

  const ClosedForm* form_;
  int largest_U_ = 0;
  int largest_V_ = 0;
  std::vector<double> mlut_;
  std::vector<double> plut_;
};

}  // namespace slipstream
