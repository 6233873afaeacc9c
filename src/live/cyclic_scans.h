#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frames/pattern_windows.h"
#include "frames/scan_camera.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Scans from a projector that repeats their patterns by itself: whole cycles of consecutive scans,
/// with each frame assigned to its pattern by PatternWindows.
class CyclicScans : public ScanCamera {
 public:
  /// `source`: started, outlives this. `scans`: number of scans in a cycle, which ends with a
  /// marker if the sequence has one. Throws Error for several scans with motion frames.
  CyclicScans(FrameSource& source, const Sequence& sequence, int scans);

  /// Frames of a cycle that begins after the previous one.
  std::optional<Glimpse> look(std::chrono::milliseconds timeout) override;
  /// Frames of the last look; nullopt before the first.
  std::optional<std::vector<FrameSet>> take() override;

 private:
  /// Frames of `window_`, scan by scan; nullopt if it shares any with the last look.
  std::optional<std::vector<FrameSet>> scans_of_window();

  static constexpr int kept_cycles = 4;  ///< cycles of frames that PatternWindows may keep

  FrameSource& source_;
  int frames_;  ///< N of each scan
  int scans_;
  PatternWindows windows_;
  Pool<Frame> pool_;
  std::vector<Pooled<Frame>> window_;
  std::vector<FrameSet> seen_;
  std::optional<std::uint64_t> newest_;  ///< sequence number at the last look
};

/// Frames of one cycle, in pattern order, from a source that repeats the sequence. Starts and stops
/// the source. Throws WorldError, naming `source`, if no complete cycle arrives.
FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source);

}  // namespace slipstream
