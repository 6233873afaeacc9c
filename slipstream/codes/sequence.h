#pragma once

#include "slipstream/codes/registry.h"

namespace slipstream {

/// What a projector shows for one scan.
struct Sequence {
  Strategy strategy{};
  Axis axis = Axis::x;
  PatternLight light{};  ///< of the patterns
  Size projector{};      ///< pixels; empty where not said
  /// A dark frame after the last pattern marks the end of each cycle; no frame of the scan.
  bool marker = false;
  /// Relative exposures of the camera, any unit: all patterns are shown for each in turn. Several
  /// are merged to one set of frames: see merged_exposures.
  std::vector<double> exposures{1};
  bool binary = false;  ///< shown a bit at a time, see PatternSet; the frames hold the same
  /// All patterns along x, which is then the axis, and after them along y: two scans, see along and
  /// Scan.
  bool both_axes = false;
  /// Frames of a scan beyond one cycle of patterns shown over and over: see motion_window.
  int motion = 0;

  friend bool operator==(const Sequence&, const Sequence&) = default;
};

/// The patterns along that axis alone.
Sequence along(Sequence sequence, Axis axis);

/// "x", "y" or, along x and then along y, "both".
std::string_view axes_of(const Sequence& sequence);
/// Sets what axes_of gives. Throws Error for another word.
void set_axes(Sequence& sequence, std::string_view axes);

/// Frames of one scan: of the strategy, for each axis and exposure, and those of motion.
int frame_count(const Sequence& sequence);

/// The patterns of a scan, for each exposure, and the marker, where there is one, as the last.
PatternSet pattern_set(const Sequence& sequence);
/// Those of a cycle: without the frames of motion.
Sequence cycle_of(Sequence sequence);
/// Frames after which the patterns come again: with the marker.
inline int cycle_length(const Sequence& sequence) {
  return frame_count(cycle_of(sequence)) + (sequence.marker ? 1 : 0);
}

/// What frames show once exposures are merged and single frames taken apart; of a window that
/// begins with pattern `first`.
Sequence merged_sequence(Sequence sequence, int first = 0);

/// Throws Error unless motion is 0, or of one cycle of one sinusoid without marker; there are 1 to
/// 16 exposures above 0; and several only if reading needs no ambient light, whose share of merged
/// frames varies from pixel to pixel.
void require_mergeable(const Sequence& sequence);

/// The patterns along x and along y that calibrate a board, whatever the sequence's axis; a marker
/// follows the last.
std::vector<PatternSet> along_both_axes(const Sequence& sequence);

/// Throws Error, naming `asked`, unless three patterns each make a colour picture.
void require_in_colour(const Sequence& sequence, const std::string& asked);

/// Throws Error where the projector's size is known and cannot show the strategy.
void require_shown(const Sequence& sequence);

/// What is said of a sequence over what is known of it: flags over a file, or over a default.
struct SequenceChanges {
  std::optional<std::string> strategy{};  ///< by name: replaces the one known whole
  std::map<std::string, std::optional<std::string>> settings{};  ///< alone they change it
  std::optional<std::vector<double>> period_pixels{};  ///< of `periods`, in projector pixels
  std::optional<double> stripe_pixels{};               ///< of `stripes`, likewise
  std::optional<std::string> axes{};                   ///< see set_axes
  std::optional<double> alpha_p{};
  std::optional<double> beta_p{};
  std::optional<Size> projector{};
  std::optional<std::vector<double>> exposures{};
  bool marker = false;  ///< a marker ends each cycle, whatever was known
  bool binary = false;  ///< shown a bit at a time, whatever was known
  std::optional<int> motion{};
  /// Takes the place of what is known, but for a projector that it does not say.
  std::optional<Sequence> known{};
};

/// Those after which a sequence is that one, whatever was known.
inline SequenceChanges changes_to(const Sequence& sequence) {
  return {.strategy = sequence.strategy.name(), .known = sequence};
}

/// The sequence with those changes. Throws Error for an unknown strategy, setting or light.
Sequence changed(const Sequence& known, const SequenceChanges& changes);

/// The default strategy, changed so. Throws Error if the projector cannot show it.
Sequence default_sequence(Size projector, const SequenceChanges& changes);

}  // namespace slipstream
