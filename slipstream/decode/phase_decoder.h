#pragma once

#include <map>
#include <string_view>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/layout.h"
#include "slipstream/decode/equations.h"
#include "slipstream/decode/phase_correction.h"
#include "slipstream/decode/phase_tables.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream {

/// How phase is computed in double. All but the last agree to 1e-12 rad; they differ in speed.
enum class PhaseMethod {
  equation,         ///< Eqs. (1.3)-(1.7), any weights, any pixel
  closed_form,      ///< Eqs. (2.1)-(2.3), (2.13)-(2.15), N = 3, 4, 6, any pixel
  tables,           ///< MLUT and PLUT, Eqs. (2.4)-(2.18), N = 3, 4, 6, 8-bit pixels
  intensity_ratio,  ///< IntensityRatio, N = 3, any pixel; to 2e-8 rad
};

/// "equation", "closed-form", "lut", "intensity-ratio".
std::string_view name_of(PhaseMethod method);

/// PhaseSample of every pixel.
struct PhaseMaps {
  Image<double> mean;
  Image<double> modulation;
  Image<double> wrapped_phase;
};

/// The bands of frames to phase, by the method asked for where it can and by the equations where it
/// cannot.
class PhaseDecoder {
 public:
  /// Tables are built here, once, for those of `steps` that have one. Every phase is corrected by
  /// what `corrections` has for its N, whichever the method. Throws Error for a correction that is
  /// empty or for another N than it stands at.
  PhaseDecoder(PhaseMethod method, const std::vector<int>& steps,
               PhaseCorrections corrections = {});

  /// The method that really decodes `steps` frames like those: `equation` where the one asked for
  /// has no form for that N or that pixel.
  [[nodiscard]] PhaseMethod method_for(int steps, const FrameViews& frames) const;
  [[nodiscard]] PhaseMethod method_for(const Band& band, const FrameViews& frames) const;

  /// Mean, modulation and wrapped phase from the `steps` frames that start at `first`.
  [[nodiscard]] PhaseMaps operator()(const FrameViews& frames, int first, int steps) const;
  /// The same of a band. Only a run of steps is corrected.
  [[nodiscard]] PhaseMaps operator()(const FrameViews& frames, const Band& band) const;

 private:
  /// Without the mirrored one.
  [[nodiscard]] PhaseMaps sinusoid(const FrameViews& frames, const Band& band) const;
  [[nodiscard]] const PhaseCorrection* correction_for(int steps) const;

  PhaseMethod method_;
  PhaseCorrections corrections_;
  std::map<int, PhaseTables> tables_;
};

}  // namespace slipstream
