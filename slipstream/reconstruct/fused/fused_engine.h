#pragma once

#include <tuple>

#include "slipstream/reconstruct/fused/fused_stages.h"

namespace slipstream {

/// The last rows of coordinates and flags that were written.
class KeptRows {
 public:
  /// Columns before the first pixel and after the last, which are NaN and confirm no neighbour: so
  /// many that rows start at whole vectors.
  static constexpr int side = least_row_width;

  /// Room for `count` rows, a power of two, of that width, the same as before or another.
  void prepare(int width, int count);
  /// Makes rows NaN: those outside the picture, or not yet known.
  void clear(int first, int last);

  [[nodiscard]] int width() const { return flags_.width(); }
  [[nodiscard]] float* coordinates(int row) { return coordinate_.row(place(row)) + side; }
  [[nodiscard]] std::int32_t* flags(int row) { return flags_.row(place(row)); }

 protected:
  [[nodiscard]] int place(int row) const { return row & (flags_.height() - 1); }

  Image<float> coordinate_;
  Image<std::int32_t> flags_;
};

/// Rows of coordinates around those that become points next: so many that the neighbourhood's vote
/// on them is the same as in the whole picture. A pixel's shift depends on its like within 9 rows
/// (three passes over windows of 5 x 5, three over 3 x 3), and those on phases 4 rows further.
class VoteBlock : public KeptRows {
 public:
  static constexpr int most_rows = 88;  ///< that become points at once
  static constexpr int voters = 10;     ///< rows around them in which pixels choose
  static constexpr int seen = 14;       ///< rows around them of which phases are seen
  static constexpr int looks_past = 4;  ///< rows that a vote looks past the last phase

  /// Room for rows of that width, the same as before or another.
  void prepare(int width);

  [[nodiscard]] OrderCosts costs(int row) {
    return {below_.row(place(row)) + side, above_.row(place(row)) + side};
  }
  /// Whether those of a pixel, and of its `costed_together`, belong to the row's coordinates.
  [[nodiscard]] std::uint8_t& costs_known(int column, int row) {
    return costs_known_(column / costed_together, place(row));
  }
  /// For coordinates that are new.
  void forget_costs(int row) {
    std::fill_n(costs_known_.row(place(row)), costs_known_.width(), std::uint8_t{0});
  }
  /// Of NeighbourhoodVote; 0 between votes, before the first pixel of a row and after the last.
  [[nodiscard]] std::int16_t* shifts(int row) { return shift_.row(place(row)) + side; }
  [[nodiscard]] BallotRows ballots(float periods);

  /// Takes back what a vote has changed, so that the next begins with what each pixel said alone.
  void forget_vote();

  /// What a vote has changed, as it was.
  struct Moved {
    PixelPlace at;
    float coordinate = 0;
    std::int32_t flags = 0;
  };
  std::vector<Moved> moved;
  std::vector<PixelPlace> disagreeing;
  std::vector<std::uint8_t> far_above;  ///< CoordinateRows::far_above of the next row
  NeighbourhoodVoteLists lists;

 private:
  Image<std::int16_t> shift_;
  Image<float> below_, above_;       ///< OrderCosts
  Image<std::uint8_t> costs_known_;  ///< of `costed_together` pixels
};

/// What the fused pass keeps of a few rows between its stages, for each band of rows. Kept from
/// scan to scan it spares allocations.
struct FusedScratch {
  KeptRows kept;                            ///< a row and its neighbours
  Image<float> turns;                       ///< a row for each band
  Image<float> unwrapped;                   ///< two rows, in turns
  Image<float> sum, coarse, mean, x, y, z;  ///< one row each
  Image<Validity> validity;
  std::tuple<std::vector<const std::uint8_t*>, std::vector<const std::uint16_t*>> frames;
  VoteBlock block;
  std::size_t packed = 0;  ///< points of the band's rows so far
};

/// All that the fused pass keeps from scan to scan.
struct FusedMemory {
  std::vector<FusedScratch> scratch;   ///< of each band of rows
  std::vector<SinusoidLimits> limits;  ///< of each band of the layout
};

/// Gives what is wanted the size of the picture; `doubtful`: the maps have doubts.
void prepare(const Outputs& outputs, Size size, bool doubtful);

/// Of `size` and with any content; an image of that size is left alone.
template <class Pixel>
void prepare(Image<Pixel>& image, Size size) {
  if (image.size() != size) image = Image<Pixel>(size, uninitialised);
}

/// Throws Error where the frames are not `count` or not of the camera's size.
void require_frames(const FrameViews& frames, int count, Size camera);

/// Frames to cloud in one pass over the pixels: no intermediate image, vectors of floats, rows
/// shared among threads in bands, no allocation once outputs and memory have been used. Thread-safe
/// with an output and memory for each thread.
///
/// Against the equations in double the wrapped phase is within 2e-6 rad for every input (where it
/// is corrected, within that times one and the correction's steepest slope), and the depth within
/// 1e-5 of itself where the stripe is at least a tenth of the field from the ray's coordinate at
/// infinity. The same pixels are valid but where a limit is met to rounding.
struct FusedEngine {
  /// None where fused_stages has none, and `why_not`. `corrections` are added to the phases.
  static std::optional<FusedEngine> make(const EngineSetup& setup,
                                         const PhaseCorrections& corrections,
                                         std::string* why_not = nullptr);

  /// `coarse`: the coordinate of each pixel, right to half a period, where unwraps_by_picture; NaN
  /// where there is none. Throws Error where it is missing then or given else, and where the frames
  /// are not quantised, not as many as the strategy's or not of the camera's size.
  void operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                  const Image<float>* coarse = nullptr) const;

  /// Whether that coordinate must be given.
  [[nodiscard]] bool wants_coarse() const { return stages->coarse_given; }

  /// The limits of each band, for such frames and outputs.
  void find_limits(const FrameViews& frames, const Outputs& output,
                   std::vector<SinusoidLimits>& limits) const;

  std::shared_ptr<const FusedStages> stages;
  ReconstructSettings settings;
};

/// Where what is written would push out of the cache what is read, and rows start at whole vectors
/// or at halves of the widest.
inline bool written_past_cache(Size size) {
  constexpr int cached_pixels = 2'000'000;
  return size.width % (least_row_width / 2) == 0 &&
         std::int64_t{size.width} * size.height > cached_pixels;
}

/// One scan on its way through the stages.
struct FusedPass {
  const FusedStages& stages;
  const FrameViews& frames;
  const Outputs& output;
  const std::vector<SinusoidLimits>& limits;  ///< of each band of the layout
  CueLimits cue_limits;
  bool past_cache;
  const Image<float>* coarse;  ///< where it is given

  [[nodiscard]] int width() const { return stages.rays.E_x.width(); }
  [[nodiscard]] int height() const { return stages.rays.E_x.height(); }
};

/// Its rows from `first` to `last`.
struct FusedBand : FusedPass {
  int first, last;
  FusedScratch& scratch;

  /// From a column on.
  [[nodiscard]] FrameRows frame_rows(int row, int column = 0) const;
  /// Where the mean goes: grey levels of the frames in a map, of 8 bits in a cloud.
  [[nodiscard]] float* mean_row(int row) const;
  [[nodiscard]] float* modulation_row(int row) const;
  /// Frames of one row to the turns of every band, and to flags and levels.
  void decode(int row, SinusoidRow to) const;
  /// What a row of the maps gets besides mean, modulation and coordinate, and the cloud from them.
  void finish_maps(int row, const float* turn) const;
  /// Points of a row: of turns or, without, of kept coordinates that its neighbours confirm.
  void finish_points(int row, KeptRows& kept, const float* turn = nullptr) const;
};

/// Block by block, of frames with a cue: what the vote needs to see is decoded, then it is held,
/// then come the points.
void voted_band(const FusedBand& band);

}  // namespace slipstream
