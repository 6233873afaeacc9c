#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Frames, what they show, and what took them: what a folder, a window of a recording or the
/// virtual scanner gives.
struct Scan {
  FrameSet frames{};
  /// Where they were put in order: frame n came as number order[n]; empty where as they came.
  std::vector<int> order{};
  Sequence sequence{};
  std::optional<Scanner> scanner{};  ///< where it is known
  std::vector<double> exposures{1};  ///< that were merged to these frames; one where none were
  /// Where the patterns were shown along both axes: what the camera took of those along y.
  std::vector<Scan> other_axis{};
  /// What further cameras took at the same time under the same projector, each with the scanner
  /// that it makes with that. The world is the frame of this scan's camera.
  std::vector<Scan> further_cameras{};
  /// What there was to say about the frames as they were read, a line each, for people.
  std::vector<std::string> warnings{};
};

/// The scan with the frames of its exposures merged to those of one, where there are several, or
/// with what they hold at once taken apart, see FrameAdapter, and those along the other axis as a
/// scan beside it: all that decodes reads it then as any other. Throws Error where the frames are
/// not as many.
Scan merged(Scan scan);

}  // namespace slipstream
