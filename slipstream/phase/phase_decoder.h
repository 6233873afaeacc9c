#pragma once

#include <map>
#include <string_view>
#include <vector>

#include "slipstream/capture/frame_set.h"
#include "slipstream/image/image.h"
#include "slipstream/phase/equations.h"
#include "slipstream/phase/phase_correction.h"
#include "slipstream/phase/phase_tables.h"

namespace slipstream {

/// How phase is computed. All but `fused` agree to 1e-12 rad; they differ in speed.
enum class Backend {
  equation,     ///< Eqs. (1.3)-(1.7), any N, any pixel
  closed_form,  ///< Eqs. (2.1)-(2.3), (2.13)-(2.15), N = 3, 4, 6, any pixel
  lut,          ///< MLUT and PLUT, Eqs. (2.4)-(2.18), N = 3, 4, 6, 8-bit pixels
  fused,        ///< frames to cloud in one pass, in float: see FusedReconstructor; `lut` where it
                ///< cannot and where phase alone is computed
};

/// "equation", "closed-form", "lut", "fused".
std::string_view name_of(Backend backend);

/// The backend of that name; throws Error for any other.
Backend backend_named(std::string_view name);

/// PhaseSample of every pixel.
struct PhaseMaps {
  Image<double> mean;
  Image<double> modulation;
  Image<double> wrapped_phase;
};

/// Frames of N-step sinusoids to phase, by the backend asked for where it can and by the equations
/// where it cannot.
class PhaseDecoder {
 public:
  /// Tables are built here, once, for those of `steps` that have one. Every phase is corrected by
  /// what `corrections` has for its N, whichever the backend. Throws Error for a correction that is
  /// empty or for another N than it stands at.
  PhaseDecoder(Backend backend, const std::vector<int>& steps, PhaseCorrections corrections = {});

  /// The backend that really decodes `steps` frames like those: `equation` where the one asked for
  /// has no form for that N or that pixel.
  [[nodiscard]] Backend backend_for(int steps, const FrameSet& frames) const;

  /// Mean, modulation and wrapped phase from the `steps` frames that start at `first`.
  [[nodiscard]] PhaseMaps operator()(const FrameSet& frames, int first, int steps) const;

 private:
  [[nodiscard]] const PhaseCorrection* correction_for(int steps) const;

  Backend backend_;
  PhaseCorrections corrections_;
  std::map<int, PhaseTables> tables_;
};

}  // namespace slipstream
