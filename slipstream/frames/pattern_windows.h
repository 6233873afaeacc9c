#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "slipstream/frames/cycle_alignment.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pool.h"

namespace slipstream {

/// How it is known which pattern a frame shows. Whichever it is, the pictures are watched, and a
/// slipped index is set right: see PatternWindows.
enum class PatternIndexing {
  told,     ///< by the source, FrameStamp::pattern_index; frames that lack it are counted on
  counted,  ///< the frame's sequence modulo the patterns: the projector triggers the camera
  marker,   ///< a dark or bright frame before the first pattern of each cycle of N + 1 frames
};

/// "told", "counted", "marker"; throws Error for any other name.
PatternIndexing pattern_indexing_named(std::string_view name);
std::vector<std::string_view> pattern_indexing_names();

/// The frames of a window, which are of one format, as they stand, into `views`, whose memory is
/// used.
void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views);

/// The same; valid as long as the window's shares are.
FrameViews views_of(const std::vector<Pooled<Frame>>& window);

/// The cycle in the middle of a window of `extra` frames more, in pattern order; `first_pattern`:
/// of the window's first frame.
FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra);

/// The windows of W frames in a row of a cycle of N patterns. Frames have positions: position p
/// shows pattern p modulo N, and a position without a frame invalidates the W windows that contain
/// it, no others. A frame may come late as long as a window can still wait for it without keeping
/// another one waiting: until the one W places on has come.
class RollingWindow {
 public:
  RollingWindow(int frames, int cycle);

  /// False where the position has a frame already, or is too late.
  bool put(std::uint64_t position, Pooled<Frame> frame);

  /// The next window that is whole; false where there is none yet. Windows come in the order of
  /// their newest frames. A window of one cycle is in pattern order, a longer one as frames came.
  bool next(std::vector<Pooled<Frame>>& window);
  /// The pattern of that window's first frame.
  [[nodiscard]] int first_pattern() const { return first_pattern_; }

  /// Forgets all frames and begins again with the next, wherever it is: it is what would have had
  /// the position `first` before. Windows that reach back across here are lost.
  void restart(std::uint64_t first);
  void restart() { restart(newest_ + 1); }

  /// Windows that will never be whole.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  struct Place {
    std::optional<std::uint64_t> position;
    Pooled<Frame> frame;
  };

  [[nodiscard]] Place& at(std::uint64_t position) { return ring_[position % ring_.size()]; }
  [[nodiscard]] bool has(std::uint64_t position) { return at(position).position == position; }
  /// Whether every frame of the window that ends at `next_` is there.
  [[nodiscard]] bool whole();
  void begin_at(std::uint64_t position);

  std::uint64_t count_, cycle_;
  std::vector<Place> ring_;
  bool begun_ = false;
  std::uint64_t newest_ = 0;  ///< position
  std::uint64_t next_ = 0;    ///< where the next window ends
  std::uint64_t lost_ = 0;
  int first_pattern_ = 0;
};

/// Patterns that are shown over and over.
struct PatternCycle {
  int patterns = 1;              ///< N: of a cycle, for each exposure, without a marker
  int extra = 0;                 ///< frames of a window beyond a cycle
  std::vector<CycleRun> runs{};  ///< see CycleAlignment
};

/// Frames in, windows of the N newest out, each in pattern order, or of the N + K newest of a
/// cycle with K extra frames, as they came. The index of a frame is known as
/// `indexing` says and checked in its picture: against the frames of the cycle before (SlipWatch)
/// and, of several sinusoids, against the others of its own (CycleAlignment). A frame that shows
/// another pattern than its index says is in no window; once a cycle of them agrees on how far they
/// have slipped, or the cycle shows it at once, indices are set right and windows made of what is
/// there. One thread uses it.
class PatternWindows {
 public:
  /// `size`: of the frames.
  PatternWindows(PatternCycle cycle, PatternIndexing indexing, Size size);

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
