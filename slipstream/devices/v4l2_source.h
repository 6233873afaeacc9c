#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "slipstream/devices/camera_description.h"
#include "slipstream/devices/camera_settings.h"
#include "slipstream/devices/frame_count.h"
#include "slipstream/devices/video_device.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// UVC and other cameras of Linux, through V4L2. Sequence and device time are the driver's, so that
/// frames which it dropped are seen. A camera that was unplugged is sought until it is back.
class V4l2Source : public FrameSource, public CameraControls {
 public:
  using Open = std::function<std::unique_ptr<VideoDevice>()>;

  /// Opens the camera; `name` is what messages call it. Throws Error where it does not take a
  /// setting, WorldError where it does not answer.
  V4l2Source(std::string name, Open open, const CameraSettings& settings);
  /// The camera /dev/video<number>.
  V4l2Source(int number, const CameraSettings& settings);
  ~V4l2Source() override;
  V4l2Source(const V4l2Source&) = delete;
  V4l2Source& operator=(const V4l2Source&) = delete;

  [[nodiscard]] FrameFormat format() const override { return format_; }
  [[nodiscard]] bool has_own_pace() const override { return true; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override;
  [[nodiscard]] SourceCounters counters() const override;
  [[nodiscard]] std::string state() const override;
  CameraControls* controls() override { return this; }
  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const override;
  void set_control(CameraControl which, double value) override;

 private:
  class Stream;

  [[nodiscard]] std::shared_ptr<Stream> shared_stream() const;
  Arrival seek(std::chrono::milliseconds timeout);
  void lose();

  std::string name_;
  Open open_;
  CameraSettings settings_;
  FrameFormat format_;
  std::shared_ptr<Stream> stream_;
  FrameCount count_;
  mutable std::mutex mutex_;  ///< of stream_ against other threads, of settings_ and of state_
  std::string state_;
  std::atomic<std::uint64_t> delivered_ = 0;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<std::uint64_t> reconnects_ = 0;
};

/// Cameras of this machine; their names are numbers.
std::vector<CameraDescription> list_v4l2_cameras();

}  // namespace slipstream
