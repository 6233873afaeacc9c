#pragma once

#include <memory>
#include <optional>
#include <string>

#include "slipstream/capture/frame_set.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/reconstruct/fused_reconstructor.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/reconstruct/reconstruction.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

class DoubleReconstructor;

/// Frames to cloud, for one scanner, strategy and axis, by the backend of the settings; tables are
/// built once. FusedReconstructor gives the same in single precision without a copy.
class Reconstructor {
 public:
  /// Throws Error where the scanner or the settings are not valid, or the strategy's frames do not
  /// give a projector coordinate.
  Reconstructor(const Scanner& scanner, const Strategy& strategy, Axis axis,
                const ReconstructSettings& settings = {});

  /// Throws Error when the frames are not of the camera's size or not as many as the strategy's.
  [[nodiscard]] Reconstruction operator()(const FrameSet& frames) const;

  /// The cloud alone, for which the fused pass makes no map.
  [[nodiscard]] Cloud cloud(const FrameSet& frames) const;

  /// How sure each point of a scan is under noise of settings.cue.noise_variance on each frame:
  /// sigma of y by Eq. (3.40) or (3.63), and of X, Y, Z through the derivative of the point.
  /// `frames` are those that the scan was made from.
  [[nodiscard]] Uncertainty uncertainty(const Reconstruction& scan, const FrameSet& frames) const;

  /// What really reconstructs such frames: "fused", or the backends of Decoder::backend_for, "lut"
  /// standing in for "fused" where the frames are not quantised or fused_stages has none.
  [[nodiscard]] std::string backend_for(const FrameSet& frames) const;

 private:
  class InDouble;

  [[nodiscard]] bool is_fused(const FrameSet& frames) const;

  std::optional<FusedReconstructor> fused_;
  std::shared_ptr<InDouble> in_double_;
};

}  // namespace slipstream
