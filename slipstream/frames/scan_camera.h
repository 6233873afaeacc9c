#pragma once

#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// What was seen of whatever stands before the camera, to judge it before a scan is taken.
struct Glimpse {
  std::vector<FrameSet> frames;  ///< all together they show it without fringes
  bool still = false;            ///< as in the glimpse before
};

/// A camera and patterns before it, of which scans are taken in step. One thread uses it.
class ScanCamera {
 public:
  virtual ~ScanCamera() = default;

  /// Waits at most `timeout`; nullopt if none came. Throws WorldError if the source has ended.
  virtual std::optional<Glimpse> look(std::chrono::milliseconds timeout) = 0;
  /// The frames of each scan, in pattern order, of what the last glimpse showed. None where
  /// something moved meanwhile, or a frame was lost.
  virtual std::optional<std::vector<FrameSet>> take() = 0;
};

/// Whether nothing moved from frames to others of the same patterns: fewer than one pixel of 200
/// differs by more than 16 of 255 grey levels, which noise does not and a board that moves by a
/// third of a pixel does. False where they differ in size or count.
bool is_still(const FrameViews& before, const FrameViews& after);

/// Frames of one format, one or more, as a set.
FrameSet frame_set_of(std::vector<Frame> frames);

/// How a camera keeps in step with what is shown.
struct StepSettings {
  /// From showing a pattern to the start of its frame: the projector's delay and the longest
  /// exposure. Unused for a source without a pace of its own.
  std::chrono::milliseconds settling{100};
  bool triggered = false;  ///< the camera waits for FrameSource::trigger
  /// s; one for each of as many groups of every scan's patterns. Empty: the camera's own.
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
