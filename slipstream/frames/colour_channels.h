#pragma once

#include "slipstream/base/colour.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

// A picture in colour is three frames taken at once: red, green, blue; so are three patterns shown.

inline constexpr int colour_channels = 3;  ///< frames to a picture in colour

/// Of a white surface under no light, red, green and blue of the projector: frames of three
/// channels each, averaged where some colour lights with a tenth of the brightest or more. Throws
/// Error for other than twelve frames, saturation, channels without light, or lights that cannot be
/// told apart.
ColourMixture measured_mixture(const FrameViews& pictures);

/// Throws Error unless all are finite and the projector's colours can be told apart.
void require_valid(const ColourMixture& mixture);

/// As many frames, 16 bits, of each projector colour alone; right for grey surfaces, for others
/// with `white`, the channels of a picture under an even grey of the projector. Where a channel of
/// a picture, or of `white`, is saturated all three frames are; where `white` is dark they are
/// dark. Throws Error unless frames come in threes and `white` is of their size.
FrameSet unmixed(const FrameViews& frames, const ColourMixture& mixture,
                 const FrameViews& white = {});

/// What people should know of pictures that are taken apart so; empty where all is well.
std::string doubt_about_colours(bool mixture_known, bool white_known);

/// A colour camera as a source of grey frames: picture n is frames 3 n to 3 n + 2, its channels.
class ColourSource : public SourceOver {
 public:
  /// `pictures`: frames of 8 bits, three times as wide as the pictures: red, green and blue of a
  /// pixel, then those of the next. Throws Error for others.
  explicit ColourSource(std::unique_ptr<FrameSource> pictures);

  [[nodiscard]] FrameFormat format() const override { return format_; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  [[nodiscard]] SourceCounters counters() const override;

 private:
  FrameFormat format_;
  Frame picture_;
  int given_;  ///< channels of it
};

/// A source of channels, as ColourSource, through `unmixed`; skips pictures that lack a channel.
class UnmixedSource : public SourceOver {
 public:
  /// `white`: see unmixed.
  UnmixedSource(std::unique_ptr<FrameSource> source, const ColourMixture& mixture,
                FrameSet white = {});

  [[nodiscard]] FrameFormat format() const override { return {source_->format().size, 16}; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;

 private:
  ColourMixture mixture_;
  FrameSet white_;
  std::vector<Frame> seen_;         ///< of the picture that comes
  std::vector<FrameStamp> stamps_;  ///< of the picture that was taken apart
  FrameSet apart_;                  ///< it
  std::size_t given_ = 0;           ///< of its frames
};

}  // namespace slipstream
