#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "decode/phase_decoder.h"
#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/kept_rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/voted_band.h"

namespace slipstream {

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

/// Memory of the fused pass, reused from scan to scan.
struct FusedMemory {
  std::vector<FusedScratch> scratch;   ///< one per band of rows
  std::vector<SinusoidLimits> limits;  ///< one per entry of FusedStages::bands
};

/// Resizes the requested outputs; `doubtful`: the maps include fringe_order_doubt.
void prepare(const Outputs& outputs, Size size, bool doubtful);

/// Resizes an image unless it has that size already; its content is unspecified.
template <class Pixel>
void prepare(Image<Pixel>& image, Size size) {
  if (image.size() != size) image = Image<Pixel>(size, uninitialised);
}

/// Throws Error unless there are `count` frames of the camera's size.
void require_frames(const FrameViews& frames, int count, Size camera);

/// Frames to cloud in one pass over the pixels: no intermediate image, vectors of floats, bands of
/// rows shared among threads, no allocation once outputs and memory have been used. Thread-safe if
/// each thread has its own output and memory.
struct FusedEngine {
  /// Returns nullopt, with `why_not`, if fused_stages does. `corrections` are added to the phases.
  static std::optional<FusedEngine> make(const EngineSetup& setup,
                                         const PhaseCorrections& corrections,
                                         std::string* why_not = nullptr);

  /// `coarse`: coordinate of each pixel, right to half a period, NaN where unknown; required if
  /// unwraps_by_picture, else not allowed. Throws Error otherwise, and if the frames are not
  /// quantised or their number or size is wrong.
  void operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                  const Image<float>* coarse = nullptr) const;

  /// Whether `coarse` is required.
  [[nodiscard]] bool wants_coarse() const { return stages->coarse_given; }

  /// Limits of each band for these frames and outputs.
  void find_limits(const FrameViews& frames, const Outputs& output,
                   std::vector<SinusoidLimits>& limits) const;

  std::shared_ptr<const FusedStages> stages;
  ReconstructSettings settings;
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

}  // namespace slipstream
