#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "decode/carrier.h"
#include "frames/pattern_windows.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Separates frames that contain several sinusoids, each with its own carrier, into frames of one
/// each, after Takeda, Ina and Kobayashi 1982: the variation (frame minus its local mean; half the
/// difference of two frames) times exp(-i k x), k the carrier, low-pass filtered by a moving mean
/// over a period of the nearest other carrier, which removes that one, and a quarter of it across.
/// A second pass uses the phase just found, as a window around the carrier distorts curved phases,
/// and the mean of the residual. Where the residual then exceeds a fifth of the carriers'
/// amplitude, as at edges and paint, all carriers are set to 0. For a grid, frames are computed
/// from the positions of its symbols, 0 where unknown.
class Demodulator {
 public:
  Demodulator(Demodulation how, Axis axis);

  /// The frames to decode, 16 bits, valid until the next call; saturated where an input frame is.
  /// Throws Error if the number of frames differs from the displayed one.
  const FrameViews& operator()(const FrameViews& shown);
  /// Moves out the frames of the last call.
  [[nodiscard]] FrameSet frames() && { return {std::move(images_), 16}; }

 private:
  /// A carrier and its C + i S.
  struct Band {
    double periods = 1;
    bool across = false;  ///< as in SpectralFrame
    Carrier carrier{};
    Size window{1, 1};  ///< of the moving mean
    Image<float> cosine{}, sine{};
  };

  void take(const FrameViews& shown);
  void locate(const FrameViews& shown);
  void find_carriers();
  void take_mean(Size window, bool started);
  void take_near(Band& band, bool started);
  void square_residual();
  void write();

  Demodulation how_;
  Axis axis_;
  std::vector<Band> bands_;           ///< one per carrier
  std::vector<std::size_t> band_of_;  ///< of each frame; unused for a mean
  bool aligned_ = true;               ///< no carrier runs across the axis
  double longest_ = 1;                ///< longest period of the carriers, pixels
  Size widest_{1, 1};                 ///< largest window
  Image<float> frame_;                ///< 8-bit grey levels; with two frames, half their difference
  Image<float> mean_;
  Image<std::uint8_t> saturated_;
  Image<float> near_cosine_, near_sine_, scratch_;
  FrameSet::Images16 images_;
  FrameViews views_;
};

/// One-off version with its own memory.
FrameSet demodulated(const Demodulation& how, Axis axis, const FrameViews& shown);

// Converts camera frames to the frames that are decoded, in one place: merges exposures, separates
// multiplexed frames, splits patterns along both axes into two scans. merged_sequence gives the
// resulting sequence. Colour images are split before, see `unmixed`.

/// Adapts the frames of one scan after another, along one axis, reusing memory.
class FrameAdapter {
 public:
  explicit FrameAdapter(const Sequence& sequence);

  /// Returns views valid until the next call; frames that need no change, or are adapted already,
  /// are returned as they are. Throws Error if their number differs from the sequence's.
  const FrameViews& operator()(const FrameViews& taken);

 private:
  std::vector<double> exposures_;  ///< to merge; empty for a single one
  int read_;                       ///< frames of the layout
  MergedFrames merged_;
  std::optional<Demodulator> demodulate_;
};

/// For a scan in memory: returns one set of frames, or the sets along x and along y.
std::vector<FrameSet> adapted(const Sequence& sequence, FrameSet taken);

/// How frames of the repeated sequence form windows; `scans` per cycle.
PatternCycle pattern_cycle(const Sequence& sequence, int scans = 1);

}  // namespace slipstream
