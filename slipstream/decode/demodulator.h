#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/demodulation.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/decode/carrier.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// Frames that hold sinusoids by their places in the spectrum to frames in which each stands alone,
/// after Takeda, Ina and Kobayashi 1982: what varies (the frame less its local mean; of two frames
/// half their difference) times exp(-i k x), k the carrier, and of that what is near frequency 0:
/// the moving mean over a period of what is nearest in the spectrum, which lets nothing of that
/// pass, and a quarter of it across. Then once more about the phase so found, for a window about
/// the carrier bends phases that curve, and about the mean of what the carriers leave. Where what
/// they leave then has more than a fifth of their strength in the surroundings, as at edges and
/// paint, the phase is a mixture: all carriers are set to 0. Of a grid the frames are made by the
/// places that its symbols give pixels, with carriers of 0 where they give none.
class Demodulator {
 public:
  Demodulator(Demodulation how, Axis axis);

  /// The frames to be read, of 16 bits, in memory that lasts until the next call; a pixel that a
  /// frame shown saturates is saturated in them. Throws Error where not as many frames are given as
  /// are shown.
  const FrameViews& operator()(const FrameViews& shown);
  /// Those of the last call, with their memory.
  [[nodiscard]] FrameSet frames() &&;

 private:
  /// A carrier, and C + i S of it.
  struct Band {
    Carrier carrier{};
    Size window{1, 1};  ///< of the moving mean
    Image<float> cosine{}, sine{};
  };

  void take(const FrameViews& shown);
  void take_apart();
  void locate(const FrameViews& shown);
  void find_carriers();
  void take_mean(Size window, bool started);
  void take_near(Band& band, bool started);
  void square_what_is_left();
  void write();

  Demodulation how_;
  Axis axis_;
  std::vector<Band> bands_;           ///< one for each carrier
  std::vector<std::size_t> band_of_;  ///< of each frame; a mean has any
  bool aligned_ = true;               ///< no carrier runs across the axis
  double longest_ = 1;                ///< pixels, of the carriers' periods
  Size widest_{1, 1};                 ///< of the windows
  Image<float> frame_;                ///< grey levels of 8 bits; of two, half their difference
  Image<float> mean_;
  Image<std::uint8_t> saturated_;
  Image<float> near_cosine_, near_sine_, scratch_;
  FrameSet::Images16 images_;
  FrameViews views_;
};

/// The same once, with memory of their own.
FrameSet demodulated(const Demodulation& how, Axis axis, const FrameViews& shown);

}  // namespace slipstream
