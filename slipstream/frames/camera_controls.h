#pragma once

#include <array>
#include <optional>

namespace slipstream {

/// What a camera may let be set while it gives frames.
enum class CameraControl {
  exposure,    ///< of each frame, ms
  gain,        ///< in the camera's unit, mostly dB
  frame_rate,  ///< Hz, of a camera that runs freely
};

inline constexpr std::array camera_controls{CameraControl::exposure, CameraControl::gain,
                                            CameraControl::frame_rate};

/// What one of them is set to, and between what it can be.
struct ControlValue {
  double value = 0;
  double least = 0;
  double most = 0;
};

/// Of a source that is a camera. From any thread, and while frames come.
class CameraControls {
 public:
  virtual ~CameraControls() = default;
  /// As the camera says it; none where it has no such setting, or is gone.
  [[nodiscard]] virtual std::optional<ControlValue> control(CameraControl which) const = 0;
  /// Frames taken from about now on are taken so; a camera that was gone is set so again. Throws
  /// Error where the camera refuses.
  virtual void set_control(CameraControl which, double value) = 0;
};

}  // namespace slipstream
