#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

// A picture in colour is three frames that were taken at once: its red, its green and its blue
// channel, in that order. A projector in colour shows three patterns at once likewise.

inline constexpr int colour_channels = 3;  ///< frames to a picture in colour

/// Of a white surface under no light of the projector, under its red, green and blue alone: frames
/// of three channels each, one after another. By the means of the pixels that some colour lights
/// with a tenth of the brightest or more. Throws Error for other than twelve frames, for saturated
/// ones, for channels that one light does not reach, and for lights that cannot be told apart.
ColourMixture measured_mixture(const FrameViews& pictures);

/// Throws Error unless all are finite and the projector's colours can be told apart.
void require_valid(const ColourMixture& mixture);

/// Frames of 16 bits of each projector colour alone; as many as there were, three for each picture.
/// They are right of a surface that reflects all colours alike; of others where `white`, the
/// channels of a picture of it under an even grey of the projector, says what it does to each.
/// Where a channel of a picture, or of the white one, is saturated all three frames are; where the
/// white one is dark they are dark. Throws Error for a number of frames that is no multiple of
/// three, and for a white picture of other frames.
FrameSet unmixed(const FrameViews& frames, const ColourMixture& mixture,
                 const FrameViews& white = {});

/// What people should know of pictures that are taken apart so; empty where all is well.
std::string doubt_about_colours(bool mixture_known, bool white_known);

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
