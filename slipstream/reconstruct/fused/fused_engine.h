#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/reconstruct/fused/fused_stages.h"
#include "slipstream/reconstruct/fused/vote_block.h"
#include "slipstream/reconstruct/outputs.h"

namespace slipstream {

/// What the fused pass keeps of a few rows between its stages, for each band of rows. Kept from
/// scan to scan it spares allocations.
struct FusedScratch {
  struct Row {
    Image<float> coordinate;  ///< padded on both sides
    Image<std::int32_t> flags;
  };
  std::array<Row, 3> rows;                  ///< a row and its neighbours, in turns
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
class FusedEngine {
 public:
  /// None where fused_stages has none. `corrections` are added to the phases.
  static std::optional<FusedEngine> make(const EngineSetup& setup,
                                         const PhaseCorrections& corrections);

  /// `coarse`: the coordinate of each pixel, right to half a period, where unwraps_by_picture; NaN
  /// where there is none. Throws Error where it is missing then or given else, and where the frames
  /// are not quantised, not as many as the strategy's or not of the camera's size.
  void operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                  const Image<float>* coarse = nullptr) const;

  /// Whether that coordinate must be given.
  [[nodiscard]] bool wants_coarse() const { return stages_.coarse_given; }

  [[nodiscard]] const FusedStages& stages() const { return stages_; }
  [[nodiscard]] const ReconstructSettings& settings() const { return settings_; }

 private:
  FusedEngine(FusedStages stages, ReconstructSettings settings);

  FusedStages stages_;
  ReconstructSettings settings_;
};

}  // namespace slipstream
