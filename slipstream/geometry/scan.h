#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/decode/frame_adapter.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Frames with their sequence and scanner: from a folder, a recording or the virtual scanner.
struct Scan {
  FrameSet frames{};
  /// Original indices if the frames were reordered: frame n was frame order[n]; otherwise empty.
  std::vector<int> order{};

  Sequence sequence{};
  std::optional<Scanner> scanner{};  ///< if known
  std::vector<double> exposures{1};  ///< merged into these frames; a single one if not merged

  /// With patterns along both axes: the scan along y.
  std::vector<Scan> other_axis{};
  /// Scans of further cameras, taken at the same time with the same projector, each with its own
  /// scanner. World coordinates are in the frame of this scan's camera.
  std::vector<Scan> further_cameras{};

  std::vector<std::string> warnings{};  ///< about reading the frames, for the user
};

/// The scans of one pose of a calibration board, each read on demand.
struct BoardScans {
  std::string name;  ///< of the pose
  std::function<Scan(Axis)> along;
};

/// Prepares a scan for decoding: merges exposures, separates multiplexed frames (see FrameAdapter),
/// and moves frames along the other axis to other_axis. Throws Error if the number of frames does
/// not match.
inline Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;

  // Only exposures, a second axis and multiplexed frames need any work.
  const Strategy& strategy = scan.sequence.strategy;
  if (frame_count(scan.sequence) == frame_count(strategy) && !strategy.demodulation()) return scan;

  scan.order.clear();  // it refers to the frames of all exposures and axes

  std::vector<FrameSet> frames = adapted(scan.sequence, std::move(scan.frames));
  scan.sequence = merged_sequence(std::move(scan.sequence));
  scan.frames = std::move(frames.front());

  if (frames.size() == 1) return scan;

  // Both axes: the frames along y become a scan of their own.
  scan.other_axis = {
      {.frames = std::move(frames.back()), .sequence = along(scan.sequence, Axis::y)}};
  scan.sequence = along(std::move(scan.sequence), Axis::x);
  return scan;
}

}  // namespace slipstream
