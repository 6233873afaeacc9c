#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/decode/frame_adapter.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Frames, what they show, and what took them: from a folder, a recording or the virtual scanner.
struct Scan {
  FrameSet frames{};
  /// Where they were put in order: frame n came as number order[n]; empty where as they came.
  std::vector<int> order{};
  Sequence sequence{};
  std::optional<Scanner> scanner{};  ///< where it is known
  std::vector<double> exposures{1};  ///< that were merged to these frames; one where none were
  /// Where the patterns were shown along both axes: what the camera took of those along y.
  std::vector<Scan> other_axis{};
  /// Of further cameras at the same time under the same projector, each with the scanner that it
  /// makes with that. The world is the frame of this scan's camera.
  std::vector<Scan> further_cameras{};
  std::vector<std::string> warnings{};  ///< about the frames as they were read, for people
};

/// The scans of one pose of a calibration board, each read when it is asked for.
struct BoardScans {
  std::string name;  ///< of the pose
  std::function<Scan(Axis)> along;
};

/// The scan as all that decodes reads it: its exposures merged to one, what its frames hold at once
/// taken apart, see FrameAdapter, and frames along the other axis as a scan beside it. Throws Error
/// where the frames are not as many.
inline Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;
  if (!needs_adapting(scan.sequence)) return scan;
  scan.order.clear();  // which is of the frames of all exposures and axes
  std::vector<FrameSet> frames = adapted(scan.sequence, std::move(scan.frames));
  scan.sequence = merged_sequence(std::move(scan.sequence));
  scan.frames = std::move(frames.front());
  if (frames.size() == 1) return scan;
  scan.other_axis = {
      {.frames = std::move(frames.back()), .sequence = along(scan.sequence, Axis::y)}};
  scan.sequence = along(std::move(scan.sequence), Axis::x);
  return scan;
}

}  // namespace slipstream
