#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/frames/scan_camera.h"

namespace slipstream {

/// How a camera keeps in step with what is shown.
struct StepSettings {
  /// From when a pattern is put on show until a frame may begin that is to show it: the projector's
  /// own delay, and the longest exposure. Frames of a source without a pace of its own begin when
  /// they are asked for, so they need none.
  std::chrono::milliseconds settling{100};
  bool triggered = false;  ///< the camera waits for FrameSource::trigger
  /// s: the patterns of each scan are as many groups, and the camera is set to one for each. Empty:
  /// it stays as it is.
  std::vector<double> exposures{};
};

/// Scans by showing pattern after pattern and taking a frame of each. While nothing is taken the
/// projector shows plain light, as bright as the brightest pattern.
class ShownScans : public ScanCamera {
 public:
  /// `source`: started. Both outlive this. `scans`: the pictures of each, of one size. Throws as
  /// PatternSink::load.
  ShownScans(PatternSink& sink, FrameSource& source,
             std::vector<std::vector<Image<std::uint8_t>>> scans, StepSettings settings = {});

  /// One frame, of plain light, with the first exposure.
  std::optional<Glimpse> look(std::chrono::milliseconds timeout) override;
  std::optional<std::vector<FrameSet>> take() override;

 private:
  /// The newest frame, into `frame_`; false where none came in time.
  bool next(std::chrono::milliseconds timeout);
  /// A frame that was begun once `pattern` was on show, into `frame_`.
  bool show(std::size_t pattern, std::chrono::milliseconds timeout);

  PatternSink& sink_;
  FrameSource& source_;
  StepSettings settings_;
  std::vector<std::size_t> counts_;  ///< patterns of each scan
  std::size_t light_ = 0;            ///< which pattern is the plain light
  bool lit_ = false;                 ///< it is on show
  Frame frame_;
  FrameSet glimpse_;
};

}  // namespace slipstream
