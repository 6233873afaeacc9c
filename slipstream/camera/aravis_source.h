#pragma once

#include <memory>
#include <string>

#include "slipstream/camera/camera_settings.h"
#include "slipstream/capture/frame_source.h"

namespace slipstream {

/// A GenICam camera over GigE Vision or USB3 Vision. Sequence: the camera's own count of frames,
/// from 0 at the start; device time: of the camera's clock; host time: when the frame is fetched.
/// A camera that is gone is sought until it is back, without an error: `state` says so meanwhile.
class AravisSource : public FrameSource {
 public:
  /// Opens the camera of that name (see list_genicam_cameras), serial number or network address;
  /// the first one found where it is empty. Throws Error where it does not take a setting,
  /// WorldError where it does not answer.
  AravisSource(std::string name, CameraSettings settings);
  ~AravisSource() override;  ///< stops; takes up to some seconds where the camera is gone
  AravisSource(const AravisSource&) = delete;
  AravisSource& operator=(const AravisSource&) = delete;

  [[nodiscard]] FrameFormat format() const override;
  [[nodiscard]] bool has_own_pace() const override { return true; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override;
  /// Starts a frame of a camera whose trigger is "Software". From any thread. A camera that is gone
  /// is not triggered.
  void trigger() override;
  [[nodiscard]] SourceCounters counters() const override;
  [[nodiscard]] std::string state() const override;
  CameraControls* controls() override;

 private:
  class Camera;
  std::unique_ptr<Camera> camera_;
};

}  // namespace slipstream
