#pragma once

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/pattern_windows.h"
#include "slipstream/frames/scan_camera.h"

namespace slipstream {

/// Scans under a projector that shows their patterns by itself, over and over, one scan after the
/// other: whole cycles, each frame in its place as PatternWindows finds it.
class CyclicScans : public ScanCamera {
 public:
  /// `source`: started, outlives this. `scans`: so many of the sequence in a cycle, which a marker
  /// ends where the sequence has one. Throws Error where there are several with frames of motion.
  CyclicScans(FrameSource& source, const Sequence& sequence, int scans);

  /// The frames of a cycle that begins after the one before.
  std::optional<Glimpse> look(std::chrono::milliseconds timeout) override;
  /// Those of the last glimpse; none before there was one.
  std::optional<std::vector<FrameSet>> take() override;

 private:
  /// The frames of the window by scan; none where it shares some with the last glimpse.
  [[nodiscard]] std::optional<std::vector<FrameSet>> cycle_of(
      const std::vector<Pooled<Frame>>& window);

  static constexpr int kept_cycles = 4;  ///< PatternWindows may keep frames of so many

  FrameSource& source_;
  int frames_;  ///< N of each scan
  int scans_;
  PatternWindows windows_;
  Pool<Frame> pool_;
  std::vector<Pooled<Frame>> window_;
  std::vector<FrameSet> seen_;
  std::optional<std::uint64_t> newest_;  ///< sequence, of the last glimpse
};

/// The frames of one cycle of a source that shows the sequence over and over, in pattern order; the
/// source is started and stopped. Throws WorldError, naming `source`, where none comes whole.
FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source);

}  // namespace slipstream
