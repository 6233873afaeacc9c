#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"

namespace slipstream {

/// A view of the scene before a scan, to judge it.
struct Glimpse {
  std::vector<FrameSet> frames;  ///< all together show the scene without fringes
  bool still = false;            ///< nothing moved since the previous one
};

/// A camera and a projector that take scans together. Use it from one thread.
class ScanCamera {
 public:
  virtual ~ScanCamera() = default;

  /// Waits up to `timeout`; nullopt on timeout. Throws WorldError if the source has ended.
  virtual std::optional<Glimpse> look(std::chrono::milliseconds timeout) = 0;
  /// Takes the frames of each scan, in pattern order, of the scene last seen. Returns nullopt if
  /// something moved meanwhile, or a frame was lost.
  virtual std::optional<std::vector<FrameSet>> take() = 0;
};

/// Whether nothing moved between two sets of frames of the same patterns: fewer than one pixel in
/// 200 differs by more than 16 of 255 grey levels. Noise stays below that; a board that moves by a
/// third of a pixel does not. False if size or count differ.
bool is_still(const FrameViews& before, const FrameViews& after);

/// Collects frames of one format, at least one, into a set.
FrameSet frame_set_of(std::vector<Frame> frames);

/// How to synchronise the camera with the display.
struct StepSettings {
  /// Time from showing a pattern to the start of its frame: the projector's delay plus the longest
  /// exposure. Ignored for a source without its own pace.
  std::chrono::milliseconds settling{100};
  bool triggered = false;  ///< use FrameSource::trigger
  /// s; one for each equal group of every scan's patterns. Empty: the camera's own exposure.
  std::vector<double> exposures{};
};

/// Takes scans by showing one pattern after another and taking a frame of each. Between scans the
/// projector shows uniform light, as bright as the brightest pattern.
class ShownScans : public ScanCamera {
 public:
  /// `source` must be started; `sink` and `source` must outlive this. `scans`: the images of each,
  /// all of one size. Throws as PatternSink::load.
  ShownScans(PatternSink& sink, FrameSource& source,
             std::vector<std::vector<Image<std::uint8_t>>> scans, StepSettings settings = {});

  /// One frame, in uniform light, with the first exposure.
  std::optional<Glimpse> look(std::chrono::milliseconds timeout) override;
  std::optional<std::vector<FrameSet>> take() override;

 private:
  /// Waits for the newest frame, into `frame_`; false on timeout.
  bool next(std::chrono::milliseconds timeout);
  /// Waits for a frame that started after `pattern` was displayed, into `frame_`.
  bool show(std::size_t pattern, std::chrono::milliseconds timeout);

  PatternSink& sink_;
  FrameSource& source_;
  StepSettings settings_;
  std::vector<std::size_t> counts_;  ///< patterns of each scan
  std::size_t light_ = 0;            ///< index of the uniform pattern
  bool lit_ = false;                 ///< it is displayed
  Frame frame_;
  FrameSet glimpse_;
};

}  // namespace slipstream
