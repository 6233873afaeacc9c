#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>

#include "app/capture.h"
#include "slipstream/viewer.h"

namespace slipstream::app {

/// Takes poses of a board until there are enough, and calibrates from them. Returns the
/// calibration's verdict. `show` may be empty; `ends` tells whether the user has stopped.
std::string take_poses(const CaptureFlags& flags, const CaptureRig& rig,
                       const std::function<void(view::Guide)>& show,
                       const std::function<bool()>& ends, Output& output);

/// Guided poses of a board, and the calibration from them, on a thread of its own, so that a window
/// can show the guide.
class GuidedPoses {
 public:
  /// Opens projector and camera, and begins. Throws like these.
  GuidedPoses(CaptureFlags flags, Output& output);
  ~GuidedPoses() { ending_ = true; }

  /// What to show, if it is new.
  std::optional<view::Guide> newest();

  /// Whether it has calibrated or failed, or the projector's window was closed. Main thread.
  [[nodiscard]] bool over() const;

  /// Takes no more poses and waits for the calibration. Returns its verdict; throws what failed.
  std::string finish();

 private:
  const CaptureFlags flags_;
  CaptureRig rig_;
  std::mutex mutex_;  ///< guards newest_
  std::optional<view::Guide> newest_;
  std::atomic<bool> ending_ = false;
  std::future<std::string> work_;  ///< uses the members above; awaited first
};

}  // namespace slipstream::app
