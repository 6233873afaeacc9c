#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "slipstream/base/colour_mixture.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// A camera in colour as a source of grey frames: of each picture its three channels one after
/// another, see colour_channels.h. Picture n is frames 3 n to 3 n + 2.
class ColourSource : public FrameSource {
 public:
  /// `pictures`: frames of 8 bits, three times as wide as the pictures: red, green and blue of a
  /// pixel, then those of the next. Throws Error for others.
  explicit ColourSource(std::unique_ptr<FrameSource> pictures);

  [[nodiscard]] FrameFormat format() const override { return format_; }
  [[nodiscard]] bool has_own_pace() const override { return pictures_->has_own_pace(); }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override { pictures_->stop(); }
  void trigger() override { pictures_->trigger(); }
  [[nodiscard]] SourceCounters counters() const override;
  [[nodiscard]] std::string state() const override { return pictures_->state(); }
  CameraControls* controls() override { return pictures_->controls(); }

 private:
  std::unique_ptr<FrameSource> pictures_;
  FrameFormat format_;
  Frame picture_;
  int given_;  ///< channels of it
};

/// Of a source of channels, as ColourSource, what `unmixed` makes of them: frames of 16 bits of
/// each of the projector's colours alone. A picture that lacks a channel is left out.
class UnmixedSource : public FrameSource {
 public:
  /// `white`: see unmixed.
  UnmixedSource(std::unique_ptr<FrameSource> source, const ColourMixture& mixture,
                FrameSet white = {});

  [[nodiscard]] FrameFormat format() const override { return {channels_->format().size, 16}; }
  [[nodiscard]] bool has_own_pace() const override { return channels_->has_own_pace(); }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override { channels_->stop(); }
  void trigger() override { channels_->trigger(); }
  [[nodiscard]] SourceCounters counters() const override { return channels_->counters(); }
  [[nodiscard]] std::string state() const override { return channels_->state(); }
  CameraControls* controls() override { return channels_->controls(); }

 private:
  std::unique_ptr<FrameSource> channels_;
  ColourMixture mixture_;
  FrameSet white_;
  std::vector<Frame> seen_;         ///< of the picture that comes
  std::vector<FrameStamp> stamps_;  ///< of the picture that was taken apart
  FrameSet apart_;                  ///< it
  std::size_t given_ = 0;           ///< of its frames
};

}  // namespace slipstream
