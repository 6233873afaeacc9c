#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/kept_rows.h"
#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/voted_band.h"
#include "slipstream/image.h"

namespace slipstream {

/// A number of rows, columns or frames as an index.
constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Resizes an image unless it has that size already; its content is unspecified.
template <class Pixel>
void prepare(Image<Pixel>& image, Size size) {
  if (image.size() != size) image = Image<Pixel>(size, uninitialised);
}

/// Buffers between the stages, one set per band of rows; reused to avoid allocation.
struct FusedScratch {
  KeptRows kept;                            ///< a row and its neighbours
  Image<float> turns, modulations;          ///< one row per band of the layout
  Image<float> unwrapped;                   ///< two rows, in turns
  Image<float> sum, coarse, mean, x, y, z;  ///< one row each
  Image<Validity> validity;
  std::tuple<std::vector<const std::uint8_t*>, std::vector<const std::uint16_t*>> frames;
  VoteBlock block;
  std::size_t packed = 0;  ///< points written so far for the band's rows
};

/// Whether to write past the cache: outputs would evict inputs, and rows start at half vectors.
inline bool written_past_cache(Size size) {
  constexpr int cached_pixels = 2'000'000;
  return size.width % (least_row_width / 2) == 0 &&
         std::int64_t{size.width} * size.height > cached_pixels;
}

/// One scan, with everything that its stages need.
struct FusedPass {
  const FusedStages& stages;
  const FrameViews& frames;
  const Outputs& output;
  const std::vector<SinusoidLimits>& limits;  ///< one per entry of FusedStages::bands
  CueLimits cue_limits;
  bool past_cache;
  const Image<float>* coarse;  ///< null if not given

  [[nodiscard]] int width() const { return stages.rays.E_x.width(); }
  [[nodiscard]] int height() const { return stages.rays.E_x.height(); }
};

/// Rows [first, last) of a scan.
struct FusedBand : FusedPass {
  int first, last;
  FusedScratch& scratch;

  /// Row of all frames, from `column` on.
  [[nodiscard]] FrameRows frame_rows(int row, int column = 0) const;
  /// Where the row's mean is written: grey levels of the frames in maps, of 8 bits in clouds.
  [[nodiscard]] float* mean_row(int row) const;
  [[nodiscard]] float* modulation_row(int row) const;
  /// Decodes a row of the frames to the turns of every band, flags and levels.
  void decode(int row, SinusoidRow to) const;
  /// Writes the wrapped phase of the maps' row, and the cloud's intensity from the mean.
  void finish_maps(int row, const float* turn) const;
  /// Points of a row, from turns or, if null, from kept coordinates that the neighbours confirm.
  void finish_points(int row, KeptRows& kept, const float* turn = nullptr) const;
};

/// Takes the rows through the stages.
void run_band(const FusedBand& band);

}  // namespace slipstream
