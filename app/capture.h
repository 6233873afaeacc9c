#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/board_flags.h"
#include "app/monitor_projector.h"
#include "app/source_flags.h"
#include "frames/scan_camera.h"
#include "slipstream/named_source.h"
#include "slipstream/sequence.h"
#include "slipstream/viewer.h"

namespace slipstream::app {

struct CaptureFlags {
  std::string output;
  SourceFlags source;
  bool no_guard = false;
  std::optional<int> monitor;
  double settle = 100;  ///< ms
  std::optional<int> poses;
  BoardFlags board;
  bool headless = false;
  Size size{1280, 800};
  std::string screenshot;
  std::optional<double> automatic;  ///< time to choose exposures and take the scan with them, s
};

/// A camera and a projector that take scans.
struct CaptureRig {
  MonitorProjector projector{};
  NamedSource opened{};
  std::unique_ptr<ScanCamera> camera{};
  std::optional<Sequence> guard{};  ///< taken after each scan
};

/// Opens projector and camera, and begins. Throws like these.
CaptureRig open_rig(const CaptureFlags& flags, Output& output);

/// The frames of one scan, and those of its guard, taken once the scene is still.
std::vector<FrameSet> still_frames(const CaptureRig& rig, Output& output);

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

/// Adds `capture`, which takes a scan, or board poses that it calibrates from.
void add_capture(const Commands& program);

}  // namespace slipstream::app
