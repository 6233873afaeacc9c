// FusedStages as the shaders read them: C++ and GLSL. A place is an index into `words`, or -1.
#ifdef __cplusplus
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "reconstruct/fused/fused_stages.h"

namespace slipstream {
#else
#include "../fused/stage_numbers.h"
#endif

const int most_bands = 16;

/// Sums of a band's frames. Each weight is (a 2^22 + b 2^11 + c) units, so that sums over
/// `most_frames` 16-bit frames are exact in 32-bit integers.
struct GpuBand {
  int first_frame, frames;
  int weights;  ///< place of a, b, c of each frame's cosine, sine and mean weights
  int whole;    ///< whether all a and b are 0
  float cosine_unit, sine_unit;
  SinusoidNumbers sinusoid;
  SinusoidLimits limits;
  int wave_terms, wave, segments, table;
  float periods, period, weight;
};

/// A sum of bands and how it is unwrapped.
struct GpuLink {
  int factors;  ///< place of one factor per band
  int alone;    ///< the band, if the sum is a single one, else -1
  UnwrapStage unwrap;
};

struct GpuCode {
  CodeNumbers bits;
  int count, frames, inverses;  ///< of the bits; `inverses` is -1 if there are none
  int against_mean;
  int reference;  ///< place of the number of weights, followed by the weights
  float mean_to_frames;
};

/// Numbers of the vote, in addition to the cue and its costs; the cue's channel is the second band.
struct GpuVote {
  float period, to_8_bits;
  float shade;              ///< of the mean, per 8-bit grey level
  float relative_share;     ///< of the cue, c_2 / c_1
  float relative_variance;  ///< of a component, relative to cue_variance
  float circle_weight;      ///< 1 / ((c_1^2 + c_2^2) component_variance)
  int lines;                ///< place of SurfaceWindow::line_cells
};

/// Start of each output plane, in groups of four pixels; -1 if not wanted.
struct GpuPlanes {
  int x SLIPSTREAM_DEFAULT(-1), y SLIPSTREAM_DEFAULT(-1), z SLIPSTREAM_DEFAULT(-1);
  int mean SLIPSTREAM_DEFAULT(-1), modulation SLIPSTREAM_DEFAULT(-1), phase SLIPSTREAM_DEFAULT(-1);
  int coordinate SLIPSTREAM_DEFAULT(-1), doubt SLIPSTREAM_DEFAULT(-1);
};

/// Output format of the points.
struct GpuPacking {
  int wanted;            ///< whether points are wanted at all
  float numbers_per_mm;  ///< 0: write Validity instead of 16-bit depth
  float offset;          ///< mm
};

#ifdef __cplusplus
struct GpuStages {
#else
layout(std430, binding = 1) readonly buffer Stages {
#endif
  int width, height;
  int plane_fours;  ///< of a frame or a plane: groups of four pixels
  int scan_words;   ///< of one scan's frames and coarse coordinates
  int scan_fours;   ///< of one scan's planes
  int links;
  int kept;  ///< words kept per pixel between the shaders
  int begins_with_code;
  int coarse_given;  ///< words before the coarse coordinates, after the frames; 0: none
  int coarse_in_field, weighs_bands;
  CoordinateStage coarse_stage, coordinate;
  CoordinateStage weighed;  ///< for coordinates that are not in turns
  GpuLink coarse;
  GpuCode code;
  PointNumbers points;
  ConsensusStage consensus;
  int lens, confirmed;  ///< place of PointStage::lens; whether neighbours must confirm
  CueNumbers cue;
  OrderCostNumbers cost;
  CueLimits cue_limits;
  GpuVote vote;
  GpuPlanes plane_at;
  GpuPacking packing;
#ifdef __cplusplus
  std::array<GpuBand, most_bands> bands;
  std::array<GpuLink, most_bands> chain;
};

/// The stages and the words that they index.
struct GpuProgramText {
  GpuStages stages;
  std::vector<int> words;
};

/// Nullopt for orders that are tried, a code alone or without a reference, a carrier, a solved
/// lens, and too many bands or frames.
std::optional<GpuProgramText> gpu_stages(const FusedStages& stages);

}  // namespace slipstream
#else
  GpuBand bands[most_bands];
  GpuLink chain[most_bands];
  int words[];
};
#endif
