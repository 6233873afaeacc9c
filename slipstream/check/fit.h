#pragma once

#include <optional>

#include "slipstream/check/frame_evidence.h"
#include "slipstream/check/geometry_evidence.h"

namespace slipstream {

/// Whether evidence is that of a right scan. The limits lie between what right scans show, real and
/// virtual ones with noise, and what mistakes do: tests/check shows both.
struct Fit {
  FrameEvidence frames{};
  bool moving = false;                         ///< CheckSettings::moving
  std::optional<GeometryEvidence> geometry{};  ///< where a scanner is known

  [[nodiscard]] bool bands_alike() const;    ///< about modulation
  [[nodiscard]] bool bands_agree() const;    ///< about phase and modulation, and in their order
  [[nodiscard]] bool patterns_made() const;  ///< frames are what such patterns make
  [[nodiscard]] bool no_seam() const;
  [[nodiscard]] bool geometry_fits() const;  ///< true where there is none
  [[nodiscard]] bool depths_fit() const;     ///< in the calibrated range; true where there is none
  [[nodiscard]] bool all() const {
    return bands_agree() && patterns_made() && no_seam() && geometry_fits() && depths_fit();
  }
  /// 0 for what could not be better; of two explanations the lesser is the likelier.
  [[nodiscard]] double misfit() const;
};

}  // namespace slipstream
