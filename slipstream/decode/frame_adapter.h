#pragma once

#include <cmath>

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/pattern_windows.h"

namespace slipstream {

/// Where pixels are in the projector's field.
struct LocatedPixels {
  explicit LocatedPixels(Size size) : coordinate(size, std::nanf("")), modulation(size) {}

  Image<float> coordinate;  ///< along the axis; NaN where it is not known
  Image<float> modulation;  ///< grey levels of the frames; 0 there
};

/// By the frames of a grid, see Demodulation. What is doubtful is left out.
LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames);

/// Of stripes down the columns, by three channels. A transition is where a channel rises or falls
/// against the strongest along a row; each row's are matched to those shown by dynamic programming
/// (after Zhang, Curless and Seitz 2002), in which the order may break at a price. Ambiguous ones,
/// and those no row beside has, are dropped; pixels between neighbouring transitions are
/// interpolated.
LocatedPixels located_by_stripes(const SymbolGrid& grid, const std::vector<Image<float>>& channels);

/// Of symbols: bright spots at the grid's pitch are neighbours, which tell the surface's slant and
/// so each symbol. All squares of symbols vote for places; pixels between four that agree are
/// interpolated.
LocatedPixels located_by_symbols(const SymbolGrid& grid, const Image<float>& picture);

/// A sinusoid's place in a picture's spectrum: cycles per pixel along rows and columns.
struct Carrier {
  double right = 0, down = 0;
};

/// The carriers of a pattern of so many periods each across the projector's field, along the
/// picture's rows or columns, in a picture of 0.4 to 2.5 times the field: the common scale at which
/// they are strongest, then each refined. Always gives an answer.
std::vector<Carrier> found_carriers(const Image<float>& picture, const std::vector<double>& periods,
                                    bool along_rows);

/// Frames that hold sinusoids, each at its place in the spectrum, to frames of one each, after
/// Takeda, Ina and Kobayashi 1982: what varies (the frame less its local mean; of two frames half
/// their difference) times exp(-i k x), k the carrier, and of that the low frequencies: the moving
/// mean over a period of the nearest other carrier, which removes that one, and a quarter of it
/// across. Then once more about the phase so found, as a window about the carrier bends curved
/// phases, and about the mean of what the carriers leave. Where that then has more than a fifth of
/// their strength, as at edges and paint, all carriers are 0. Of a grid the frames are made from
/// the places of its symbols, 0 where there are none.
class Demodulator {
 public:
  Demodulator(Demodulation how, Axis axis);

  /// The frames to be read, 16 bits, valid until the next call; saturated where a given frame is.
  /// Throws Error for another number of frames than are shown.
  const FrameViews& operator()(const FrameViews& shown);
  /// Those of the last call, with their memory.
  [[nodiscard]] FrameSet frames() && { return {std::move(images_), 16}; }

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

// Frames as a camera took them become frames as they are decoded, in one place: several exposures
// are merged, what a frame holds at once is taken apart, patterns along both axes become two scans.
// merged_sequence says what they show then. Pictures in colour come apart before, see `unmixed`.

/// The frames of one scan after another, along one axis; memory is kept.
class FrameAdapter {
 public:
  explicit FrameAdapter(const Sequence& sequence);

  /// In memory that lasts until the next call; frames that need nothing, or are adapted already, as
  /// they are. Throws Error where they are not as many as the sequence shows.
  const FrameViews& operator()(const FrameViews& taken);

 private:
  std::vector<double> exposures_;  ///< to be merged; empty for one
  int read_;                       ///< frames of the layout
  MergedFrames merged_;
  std::optional<Demodulator> demodulate_;
};

/// Whether frames of the sequence differ from those that are decoded.
bool needs_adapting(const Sequence& sequence);

/// The same for a scan that is kept: one set of frames, or those along x and those along y.
std::vector<FrameSet> adapted(const Sequence& sequence, FrameSet taken);

/// How frames of the sequence, shown over and over, form windows; `scans` of them in a cycle.
PatternCycle pattern_cycle(const Sequence& sequence, int scans = 1);

}  // namespace slipstream
