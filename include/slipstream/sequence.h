#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/strategy.h"

namespace slipstream {

/// The patterns of one scan and how they are displayed.
struct Sequence {
  Strategy strategy{};
  Axis axis = Axis::x;
  PatternLight light{};  ///< of the patterns
  Size projector{};      ///< pixels; 0x0 if unknown
  /// A dark frame after the last pattern marks the end of each cycle; it is not part of the scan.
  bool marker = false;
  /// Relative camera exposures, any unit: all patterns are shown for each in turn. Several are
  /// merged into one set of frames: see merged_exposures.
  std::vector<double> exposures{1};
  bool binary = false;  ///< dithered to 1 bit, see PatternSet; the frames are the same
  /// All patterns along x, which is then the axis, followed by all along y: two scans, see along
  /// and Scan.
  bool both_axes = false;
  /// Frames of a scan beyond one cycle of repeated patterns, whose steps cancel motion.
  int motion = 0;
  /// `periods` and `stripes` as lengths in projector pixels, if given so: for the other axis.
  StrategySettings lengths{};

  friend bool operator==(const Sequence&, const Sequence&) = default;
};

/// The patterns along that axis alone.
Sequence along(Sequence sequence, Axis axis);

/// Frames of one exposure along each axis of the sequence: lengths in projector pixels may make a
/// longer code along one of them.
std::vector<int> frames_along_axes(const Sequence& sequence);

/// "x", "y", or "both" (along x, then along y).
std::string_view axes_of(const Sequence& sequence);

/// Sets the axes from such a word. Throws Error for any other.
void set_axes(Sequence& sequence, std::string_view axes);

/// Frames of one scan: those along each axis, for each exposure, plus motion frames.
int frame_count(const Sequence& sequence);

/// The patterns of a scan, for each exposure, with the optional marker last.
PatternSet pattern_set(const Sequence& sequence);

/// One cycle of the sequence: without motion frames.
Sequence cycle_of(Sequence sequence);

/// Frames after which the patterns repeat, including the marker.
inline int cycle_length(const Sequence& sequence) {
  return frame_count(cycle_of(sequence)) + (sequence.marker ? 1 : 0);
}

/// The sequence of the frames after exposures are merged and multiplexed frames separated, for a
/// window that starts with pattern `first`.
Sequence merged_sequence(Sequence sequence, int first = 0);

/// Throws Error unless motion is 0, or the sequence is one cycle of one sinusoid without marker;
/// there are 1 to 16 exposures above 0; and several only if decoding does not require the ambient
/// light, whose share of merged frames varies from pixel to pixel.
void require_mergeable(const Sequence& sequence);

/// The patterns along x and along y for calibrating with a board, whatever the sequence's axis; a
/// marker follows the last.
std::vector<PatternSet> along_both_axes(const Sequence& sequence);

/// Throws Error, beginning with `asked`, unless every three patterns form a colour picture.
void require_in_colour(const Sequence& sequence, const std::string& asked);

/// Throws Error if the projector's size is known and cannot show the strategy.
void require_shown(const Sequence& sequence);

/// Changes to a known sequence: flags that override a file or a default.
struct SequenceChanges {
  std::optional<std::string> strategy{};  ///< by name: replaces the known strategy entirely
  std::map<std::string, std::optional<std::string>> settings{};  ///< alone, they change the known
                                                                 ///< one
  std::optional<std::vector<double>> period_pixels{};            ///< lengths, projector pixels
  std::optional<double> stripe_pixels{};  ///< `stripes`, as their width in pixels
  std::optional<std::string> axes{};      ///< see set_axes
  std::optional<double> alpha_p{};
  std::optional<double> beta_p{};
  std::optional<Size> projector{};
  std::optional<std::vector<double>> exposures{};
  bool marker = false;  ///< adds a marker after each cycle
  bool binary = false;  ///< dithers to 1 bit
  std::optional<int> motion{};
  /// Replaces the known sequence, except that it keeps the known projector if this has none.
  std::optional<Sequence> known{};
};

/// Changes that turn any known sequence into that one.
inline SequenceChanges changes_to(const Sequence& sequence) {
  return {.strategy = sequence.strategy.name(), .known = sequence};
}

/// The sequence with those changes. Throws Error for an unknown strategy, setting or light.
Sequence changed(const Sequence& known, const SequenceChanges& changes);

/// The default sequence with those changes. Throws Error if the projector cannot show it.
Sequence default_sequence(Size projector, const SequenceChanges& changes);

}  // namespace slipstream
