#pragma once

#include <bitset>
#include <cstdint>

namespace slipstream {

/// Counts what is missing in the sequence of a source's frames.
class SequenceWatch {
 public:
  /// How far back a frame is taken for one that came late, not for a count begun anew.
  static constexpr std::uint64_t memory = 64;

  enum class Kind {
    fresh,     ///< after all others, or one that was missing
    repeated,  ///< this one was here
    restart,   ///< the source counts from the beginning again
  };

  Kind look(std::uint64_t sequence);
  /// A frame came that was not whole. It has taken a number of the sequence, or the next gap will
  /// not tell.
  void damaged() { ++damaged_; }

  /// Frames missing so far; one that comes late is missing no longer.
  [[nodiscard]] std::uint64_t lost() const { return lost_ + damaged_; }

 private:
  std::bitset<memory> seen_;  ///< bit i: expected_ - 1 - i
  bool begun_ = false;
  std::uint64_t expected_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t damaged_ = 0;  ///< since the last frame
};

}  // namespace slipstream
