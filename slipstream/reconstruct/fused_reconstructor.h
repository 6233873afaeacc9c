#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "slipstream/capture/frame_set.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/reconstruct/fused_stages.h"
#include "slipstream/reconstruct/multiplexed_block.h"

namespace slipstream {

/// What the fused pass keeps of a few rows between its stages, for each band of rows.
struct FusedScratch {
  struct Row {
    Image<float> coordinate;  ///< padded on both sides
    Image<std::int32_t> flags;
  };
  std::array<Row, 3> rows;            ///< a row and its neighbours, in turns
  Image<float> turn, low_turn, mean;  ///< images for their alignment
  std::tuple<std::vector<const std::uint8_t*>, std::vector<const std::uint16_t*>> frames;
  MultiplexedBlock block;
};

/// An organised cloud in single precision, as the fused pass writes it. Made once and handed in for
/// each scan, it is written anew without allocation.
struct FusedCloud {
  Image<float> x, y, z;    ///< mm, camera's frame; NaN where not valid
  Image<float> intensity;  ///< the mean A^c, grey levels of an 8-bit camera
  Image<Validity> validity;
  std::vector<FusedScratch> scratch;  ///< nothing to read in it
};

/// The same in double precision, as files are written from it.
Cloud cloud_of(const FusedCloud& points);

/// Depth alone: less is computed and written.
struct FusedDepth {
  Image<float> z;  ///< mm; NaN where not valid
  Image<Validity> validity;
  std::vector<FusedScratch> scratch;
};

/// Before geometry: as DecodedScan, in single precision. Coordinates are not confirmed by their
/// neighbours here.
struct FusedDecoding {
  Image<float> mean, modulation, wrapped_phase, fringe_order_doubt, coordinate;
  std::vector<FusedScratch> scratch;
};

/// Frames to cloud in one pass over the pixels: no intermediate image, vectors of floats, rows
/// shared among threads in bands, no allocation once the output has been used. Thread-safe with an
/// output for each thread.
///
/// Against the equations in double the wrapped phase is within 2e-6 rad for every input (where it
/// is corrected, within that times one and the correction's steepest slope), and the depth within
/// 1e-5 of itself where the stripe is at least a tenth of the field from the ray's coordinate at
/// infinity. The same pixels are valid but where a limit is met to rounding.
class FusedReconstructor {
 public:
  /// None where fused_stages has none. Throws Error as Reconstructor does.
  static std::optional<FusedReconstructor> make(const Scanner& scanner, const Strategy& strategy,
                                                Axis axis, const ReconstructSettings& settings);

  /// The frames as they stand in memory, `full_scale` their largest grey level. They must be as
  /// many as the strategy's and of the camera's size: Error where not.
  void operator()(const Frames<std::uint8_t>& frames, FusedCloud& cloud) const;
  void operator()(const Frames<std::uint16_t>& frames, double full_scale, FusedCloud& cloud) const;

  /// Of quantised frames; throws Error for others.
  void operator()(const FrameSet& frames, FusedCloud& cloud) const;
  void operator()(const FrameSet& frames, FusedDepth& depth) const;
  void operator()(const FrameSet& frames, FusedDecoding& decoding) const;

 private:
  FusedReconstructor(FusedStages stages, ReconstructSettings settings);

  template <class Pixel, class Output>
  void run(const Frames<Pixel>& frames, double full_scale, Output& output) const;

  FusedStages stages_;
  ReconstructSettings settings_;
};

}  // namespace slipstream
