#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/cycle_alignment.h"
#include "slipstream/frames/frame.h"
#include "slipstream/frames/frame_samples.h"
#include "slipstream/frames/pattern_indexing.h"
#include "slipstream/frames/pool.h"
#include "slipstream/frames/rolling_window.h"
#include "slipstream/frames/slip_watch.h"

namespace slipstream {

/// Frames in, windows of the N newest out, each in pattern order, or of the N + K newest of a
/// sequence with K frames of motion, as they came. The index of a frame is known as
/// `indexing` says and checked in its picture: against the frames of the cycle before (SlipWatch)
/// and, of several sinusoids, against the others of its own (CycleAlignment). A frame that shows
/// another pattern than its index says is in no window; once a cycle of them agrees on how far they
/// have slipped, or the cycle shows it at once, indices are set right and windows made of what is
/// there. One thread uses it.
class PatternWindows {
 public:
  /// `scans`: so many that the projector shows after each other in a cycle.
  PatternWindows(const Sequence& sequence, PatternIndexing indexing, Size size, int scans = 1);

  /// False where the frame came again, or too late.
  bool put(const Pooled<Frame>& frame);

  /// The next whole window, into `window`; false where there is none yet.
  bool next(std::vector<Pooled<Frame>>& window) { return window_.next(window); }
  /// The pattern of its first frame: see merged_sequence.
  [[nodiscard]] int first_pattern() const { return window_.first_pattern(); }

  /// The source counts its frames from the beginning again.
  void restart();

  /// Windows without all their frames.
  [[nodiscard]] std::uint64_t lost() const { return window_.lost(); }
  [[nodiscard]] std::uint64_t resynchronisations() const { return resynchronisations_; }

 private:
  struct Place {
    int index = 0;               ///< in the cycle; the marker has the last
    std::uint64_t position = 0;  ///< in the row of pattern frames; the marker that of the next
  };

  [[nodiscard]] Place place_of(std::uint64_t sequence) const;
  [[nodiscard]] bool is_marker(const Place& place) const { return place.index == patterns_; }
  void follow_source(const FrameStamp& stamp);
  void remember(const Pooled<Frame>& frame);
  /// Puts it in the window, if it is a pattern.
  bool place(const Pooled<Frame>& frame);
  /// Indices are that many places on, from the oldest of the recent frames.
  void move_on(int places);
  /// By how many places the last cycle shows its indices to be wrong; none where it shows nothing.
  [[nodiscard]] std::optional<int> realignment();

  int patterns_;  ///< N, for each exposure
  int cycle_;     ///< and a marker where there is one
  PatternIndexing indexing_;
  SampleGrid grid_;
  CycleAlignment alignment_;
  SlipWatch watch_;
  RollingWindow window_;
  bool aligned_;
  int told_ = 0;     ///< index minus sequence, as the source has it
  int slipped_ = 0;  ///< what was found to be added to that
  bool begun_ = false;
  std::uint64_t newest_ = 0;           ///< sequence
  std::uint64_t first_ = 0;            ///< sequence of the first frame whose index is counted thus
  std::vector<Pooled<Frame>> recent_;  ///< a cycle of frames, the oldest first
  std::vector<float> samples_;
  std::uint64_t resynchronisations_ = 0;
};

}  // namespace slipstream
