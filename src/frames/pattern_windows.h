#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "frames/cycle_alignment.h"
#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"

namespace slipstream {

/// Views of the frames of a window, of one format, into `views`; reuses its memory.
void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views);
/// The same for the pictures of a second camera: no views without one.
void view_second(const std::vector<Pooled<Frame>>& window, FrameViews& views);

/// Returns the views; valid as long as the window's shares.
FrameViews views_of(const std::vector<Pooled<Frame>>& window);

/// The cycle in the middle of a window with `extra` additional frames, in pattern order;
/// `first_pattern`: of the window's first frame.
FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra);

/// Windows of W successive frames of a cycle of N patterns. Position p shows pattern p modulo N; a
/// missing frame invalidates only the W windows that contain it. A frame may arrive late until the
/// one W places later has arrived, so that it delays no other window.
class RollingWindow {
 public:
  RollingWindow(int frames, int cycle);

  /// False if the position already has a frame, or is too old.
  bool put(std::uint64_t position, Pooled<Frame> frame);

  /// The next complete window; false if there is none yet. Windows are ordered by their newest
  /// frames. A window of one cycle is in pattern order, a longer one in frame order.
  bool next(std::vector<Pooled<Frame>>& window);
  /// Pattern of the window's first frame.
  [[nodiscard]] int first_pattern() const { return first_pattern_; }

  /// Drops all frames and restarts with the next one, whatever its position; it would have been
  /// `first` in the old numbering. Windows that would reach back across the restart are lost.
  void restart(std::uint64_t first);
  void restart() { restart(newest_ + 1); }

  /// Gives up the windows that end at `last` or earlier.
  void give_up(std::uint64_t last);

  /// Windows that can never be complete.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  struct Place {
    std::optional<std::uint64_t> position;
    Pooled<Frame> frame;
  };

  [[nodiscard]] Place& at(std::uint64_t position) { return ring_[position % ring_.size()]; }
  [[nodiscard]] bool has(std::uint64_t position) { return at(position).position == position; }

  std::uint64_t count_, cycle_;
  std::vector<Place> ring_;
  bool begun_ = false;
  std::uint64_t newest_ = 0;  ///< position
  std::uint64_t next_ = 0;    ///< last position of the next window
  std::uint64_t lost_ = 0;
  int first_pattern_ = 0;
};

struct PatternCycle {
  int patterns = 1;              ///< N per cycle, for each exposure, without a marker
  int extra = 0;                 ///< frames of a window beyond a cycle
  std::vector<CycleRun> runs{};  ///< see CycleAlignment
};

/// Turns frames into windows of the newest N, in pattern order, or of N + K with K extra frames, in
/// frame order. Indices come from `indexing` and are checked against the images: against the
/// previous cycle (SlipWatch) and, with several sinusoids, against each other (CycleAlignment). A
/// frame that contradicts its index is in no window; once a full cycle agrees on the slip, or one
/// cycle shows it at once, indices are corrected and windows made of the frames at hand. Use it
/// from one thread.
class PatternWindows {
 public:
  /// `size`: of the frames.
  PatternWindows(PatternCycle cycle, PatternIndexing indexing, Size size);

  /// False if the frame is a duplicate or too late.
  bool put(const Pooled<Frame>& frame);

  /// The next complete window, into `window`; false if there is none yet.
  bool next(std::vector<Pooled<Frame>>& window) { return window_.next(window); }
  /// Pattern of its first frame: see merged_sequence.
  [[nodiscard]] int first_pattern() const { return window_.first_pattern(); }

  /// Call when the source restarts its frame count.
  void restart();
  /// Call at the end: incomplete windows of the frames so far are lost.
  void finish();

  /// Windows lost because of missing frames.
  [[nodiscard]] std::uint64_t lost() const { return window_.lost(); }
  [[nodiscard]] std::uint64_t resynchronisations() const { return resynchronisations_; }

 private:
  struct Place {
    int index = 0;               ///< in the cycle; the marker is last
    std::uint64_t position = 0;  ///< among pattern frames; for the marker, the position of the next
  };

  [[nodiscard]] Place place_of(std::uint64_t sequence) const;
  void follow_source(const FrameStamp& stamp);
  /// Adds the frame to the window if it is a pattern.
  bool place(const Pooled<Frame>& frame);
  /// Shifts the indices by that many places, from the oldest recent frame on.
  void move_on(int places);
  /// Shift by which the last cycle contradicts its indices; nullopt if it does not.
  [[nodiscard]] std::optional<int> realignment();

  int patterns_;  ///< N, for each exposure
  int cycle_;     ///< including the optional marker
  PatternIndexing indexing_;
  std::vector<std::size_t> sampled_;  ///< see sample_places
  CycleAlignment alignment_;
  SlipWatch watch_;
  RollingWindow window_;
  bool aligned_;
  int source_offset_ = 0;  ///< index minus sequence number, as known from the source
  int slipped_ = 0;        ///< detected correction to source_offset_
  bool begun_ = false;
  std::uint64_t newest_ = 0;           ///< sequence number
  std::uint64_t first_ = 0;            ///< first sequence number with this shift
  std::vector<Pooled<Frame>> recent_;  ///< one cycle of frames, oldest first
  std::vector<float> samples_;
  std::uint64_t resynchronisations_ = 0;
};

}  // namespace slipstream
