#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slipstream/frames/frame.h"
#include "slipstream/frames/pool.h"

namespace slipstream {

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

}  // namespace slipstream
