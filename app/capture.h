#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/board_flags.h"
#include "app/monitor_projector.h"
#include "app/source_flags.h"
#include "app/turntable.h"
#include "frames/scan_camera.h"
#include "slipstream/named_source.h"
#include "slipstream/sequence.h"

namespace slipstream::app {

struct CaptureFlags {
  std::string output;
  SourceFlags source;
  bool no_guard = false;
  std::optional<int> monitor;
  double settle = 100;  ///< ms
  std::optional<int> poses;
  TurntableFlags turntable;
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

/// Adds --monitor, --settle and --rate.
void add_monitor_flags(const FlagGroup& command, CaptureFlags& flags);

/// Opens projector and camera, and begins. Throws like these. `turn`: of the virtual turntable,
/// degrees.
CaptureRig open_rig(const CaptureFlags& flags, Output& output, double turn = 0);

/// The frames of one scan, and those of its guard, taken once the scene is still.
std::vector<FrameSet> still_frames(const CaptureRig& rig, Output& output);

}  // namespace slipstream::app
