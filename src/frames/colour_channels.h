#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"
#include "slipstream/image.h"

namespace slipstream {

// A colour picture is three frames taken at once, red, green and blue, or three patterns shown.

inline constexpr int colour_channels = 3;  ///< frames per colour image

/// Mixture from images of a white surface with the projector off, red, green and blue: three
/// channel frames each, averaged where some colour gives a tenth of the brightest level or more.
/// Throws Error for any number but twelve frames, for saturation, channels without light, or
/// colours the camera cannot separate.
ColourMixture measured_mixture(const FrameViews& pictures);

/// Throws Error unless all entries are finite and the projector's colours can be separated.
void require_valid(const ColourMixture& mixture);

/// Separates the projector colours into as many 16-bit frames, one per colour. Correct for grey
/// surfaces; for others with `white`, the channels of a picture under uniform grey light. Where a
/// channel of a picture, or of `white`, is saturated, all three frames are; where `white` is dark,
/// they are dark. Throws Error unless frames come in threes and `white` has their size.
FrameSet unmixed(const FrameViews& frames, const ColourMixture& mixture,
                 const FrameViews& white = {});

/// Warning about separated colour images, for the user; otherwise empty.
std::string doubt_about_colours(bool mixture_known, bool white_known);

/// A colour camera as a source of grey frames: image n becomes frames 3 n to 3 n + 2, its channels.
class ColourSource : public SourceOver {
 public:
  /// `pictures`: 8-bit frames three times as wide as the image, with red, green and blue
  /// interleaved per pixel. Throws Error for others.
  explicit ColourSource(std::unique_ptr<FrameSource> pictures);

  [[nodiscard]] FrameFormat format() const override { return format_; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  [[nodiscard]] SourceCounters counters() const override;

 private:
  FrameFormat format_;
  Frame picture_;
  int returned_;  ///< channels of picture_ already returned
};

/// Applies `unmixed` to a source such as ColourSource; skips images that lack a channel.
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
  std::vector<Frame> seen_;         ///< of the incoming image
  std::vector<FrameStamp> stamps_;  ///< of the separated image
  FrameSet apart_;                  ///< the separated image
  std::size_t returned_ = 0;        ///< frames of apart_ already returned
};

}  // namespace slipstream
