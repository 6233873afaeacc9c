#pragma once

#include <array>
#include <map>
#include <span>
#include <vector>

#include "decode/equations.h"
#include "slipstream/frame_set.h"
#include "slipstream/layout.h"
#include "slipstream/maps.h"

namespace slipstream {

/// Correction added to the wrapped phase of N steps for the projector's response: minus Delta phi
/// of Liu 2010, Eqs. (4.45), (4.56), with N periods over the measured phase's circle.
struct PhaseCorrection {
  int steps = 0;              ///< N, >= 3; 1: for the whole circle of other frames
  std::vector<double> added;  ///< rad, at measured phase 2 pi i / (N added.size()); interpolated
};

/// One correction for each N that needs one; other N are not corrected.
using PhaseCorrections = std::map<int, PhaseCorrection>;

/// Throws Error unless the correction is for that many steps, N >= 3 or 1, and has finite entries.
void require_valid(const PhaseCorrection& correction, int steps);

/// `phi` without the effect of the projector's response; both in [0, 2 pi).
double corrected_phase(const PhaseCorrection& correction, double phi);

/// MLUT and PLUT of Liu 2010, Eqs. (2.4)-(2.18): modulation and wrapped phase of every (U, V) that
/// 3, 4 or 6 frames of 8 bits can give, in double, so as exact as the equations. N = 3: 4.2 MB
/// each; N = 4: 2.1 MB; N = 6: 16.7 MB.
class PhaseTables {
 public:
  /// Throws Error unless `steps` is 3, 4 or 6. With a correction the PLUT contains corrected phase,
  /// at no later cost; null: no correction.
  explicit PhaseTables(int steps, const PhaseCorrection* correction = nullptr);

  [[nodiscard]] const ClosedForm& form() const { return *form_; }
  /// Largest |U| and |V| of 8-bit frames.
  [[nodiscard]] int largest_U() const { return largest_U_; }
  [[nodiscard]] int largest_V() const { return largest_V_; }

  /// B^c in grey levels, |U| <= largest_U(), |V| <= largest_V().
  [[nodiscard]] double mlut(int U, int V) const { return mlut_[position(U, V)]; }
  /// phi in rad, [0, 2 pi), corrected if the tables were built with a correction.
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

/// The wrapped phase of three steps without an arctangent (Huang and Zhang, Applied Optics 45(21),
/// 2006): the order of the intensities gives the sixth of the circle, and a table of the ratio
/// (middle - least) / (greatest - least) the angle in it.
class IntensityRatio {
 public:
  IntensityRatio();

  /// phi, rad, [0, 2 pi), to 2e-8; 0 if all three are equal. `intensities`: of Eq. (1.1), N = 3.
  [[nodiscard]] double wrapped_phase(std::span<const double> intensities) const;

 private:
  static constexpr int segments = 4096;

  std::array<double, segments + 1> angle_{};  ///< rad, [0, pi / 3], at ratio i / segments
};

/// PhaseSample of every pixel.
struct PhaseMaps {
  Image<double> mean, modulation, wrapped_phase;
};

/// Decodes bands to phase, by the given method if possible, otherwise by the equations.
class PhaseDecoder {
 public:
  /// Builds tables for the `steps` that have one. All methods correct phases by the entry of
  /// `corrections` for their N. Throws Error for an invalid correction.
  PhaseDecoder(PhaseMethod method, const std::vector<int>& steps,
               PhaseCorrections corrections = {});

  /// The method used for such frames: `equation` if the given one does not support N or pixel.
  [[nodiscard]] PhaseMethod method_for(int steps, const FrameViews& frames) const;
  [[nodiscard]] PhaseMethod method_for(const Band& band, const FrameViews& frames) const;

  /// Mean, modulation and wrapped phase from the `steps` frames that start at `first`.
  [[nodiscard]] PhaseMaps operator()(const FrameViews& frames, int first, int steps) const;
  /// The same for a band. Without a run of steps, the correction for 1 step applies.
  [[nodiscard]] PhaseMaps operator()(const FrameViews& frames, const Band& band) const;

 private:
  /// Ignores the mirrored one.
  [[nodiscard]] PhaseMaps sinusoid(const FrameViews& frames, const Band& band) const;
  [[nodiscard]] const PhaseCorrection* correction_for(int steps) const;

  PhaseMethod method_;
  PhaseCorrections corrections_;
  std::map<int, PhaseTables> tables_;
};

}  // namespace slipstream
