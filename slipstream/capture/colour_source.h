#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "slipstream/capture/frame_set.h"
#include "slipstream/capture/frame_source.h"
#include "slipstream/image/colour_mixture.h"

namespace slipstream {

/// A camera in colour as a source of grey frames: of each picture its three channels one after
/// another, or with a mixture what `unmixed` makes of them, see colour_channels.h. Picture n is
/// frames 3 n to 3 n + 2.
class ColourSource : public FrameSource {
 public:
  /// `pictures`: frames of 8 bits, three times as wide as the pictures: red, green and blue of a
  /// pixel, then those of the next. Throws Error for others.
  ColourSource(std::unique_ptr<FrameSource> pictures, std::optional<ColourMixture> mixture);

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
  void take_apart();

  std::unique_ptr<FrameSource> pictures_;
  std::optional<ColourMixture> mixture_;
  FrameFormat format_;
  Frame picture_;
  FrameSet apart_;  ///< of the picture
  int given_;       ///< of those
};

}  // namespace slipstream
