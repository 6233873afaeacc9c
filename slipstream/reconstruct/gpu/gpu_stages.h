// FusedStages as the shaders read them: C++ and GLSL. A place is an index of `words`, -1 where
// there is nothing.
#ifdef __cplusplus
#pragma once

#include "slipstream/reconstruct/fused/fused_stages.h"

namespace slipstream {
#else
#include "../fused/stage_numbers.h"
#endif

const int most_bands = 16;

/// The sums of a band's frames. Each weight is (a 2^22 + b 2^11 + c) of a unit, so that sums over
/// `most_frames` frames of 16 bits are exact in integers of 32.
struct GpuBand {
  int first_frame, frames;
  int weights;  ///< place of a, b, c of the cosine, of the sine, and the mean's, of each frame
  int whole;    ///< whether a and b are 0 in all of them
  float cosine_unit, sine_unit;
  SinusoidNumbers sinusoid;
  SinusoidLimits limits;
  int wave_terms, wave, segments, table;
  float periods, period, weight;
};

/// A sum of bands and how it is unwrapped.
struct GpuLink {
  int factors;  ///< place of one for each band
  int alone;    ///< the band whose sum it is, or -1
  UnwrapStage unwrap;
};

struct GpuCode {
  CodeNumbers bits;
  int count, frames, inverses;  ///< of the bits; inverses are -1 where there are none
  int against_mean;
  int reference;  ///< place of how many weights there are, and these
  float mean_to_frames;
};

/// What the vote needs beside a cue and its costs; the channel of the cue is the second band.
struct GpuVote {
  float period, to_8_bits;
  float shade;              ///< of the mean, by a grey level of 8 bits
  float relative_share;     ///< of the cue's, c_2 / c_1
  float relative_variance;  ///< of a component, in cue_variance
  float circle_weight;      ///< 1 / ((c_1^2 + c_2^2) component_variance)
  int lines;                ///< place of SurfaceWindow::line_cells
};

/// Where planes of the output begin, in fours of pixels; -1 for those that are not wanted.
struct GpuPlanes {
  int x SLIPSTREAM_DEFAULT(-1), y SLIPSTREAM_DEFAULT(-1), z SLIPSTREAM_DEFAULT(-1);
  int mean SLIPSTREAM_DEFAULT(-1), modulation SLIPSTREAM_DEFAULT(-1), phase SLIPSTREAM_DEFAULT(-1);
  int coordinate SLIPSTREAM_DEFAULT(-1), doubt SLIPSTREAM_DEFAULT(-1);
};

/// What is made of the points.
struct GpuPacking {
  int wanted;            ///< points at all
  float numbers_per_mm;  ///< 0: reasons are wanted
  float offset;          ///< mm
};

#ifdef __cplusplus
struct GpuStages {
#else
layout(std430, binding = 1) readonly buffer Stages {
#endif
  int width, height;
  int plane_fours;  ///< of a frame, a plane: fours of pixels
  int scan_words;   ///< of a scan's frames and coarse coordinates
  int scan_fours;   ///< of its planes
  int links;
  int kept;  ///< words of a pixel between the shaders
  int begins_with_code;
  int coarse_given;  ///< words before the coarse coordinates that follow the frames; 0: none
  int coarse_in_field, weighs_bands;
  CoordinateStage coarse_stage, coordinate;
  CoordinateStage weighed;  ///< of coordinates that are not in turns
  GpuLink coarse;
  GpuCode code;
  PointNumbers points;
  ConsensusStage consensus;
  int lens, confirmed;  ///< place of PointStage::lens; whether neighbours are asked
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

/// Those stages, and the words that they point into.
struct GpuProgramText {
  GpuStages stages;
  std::vector<int> words;
};

/// None where the shaders cannot stand in: for more bands or frames than they take.
std::optional<GpuProgramText> gpu_stages(const FusedStages& stages);

}  // namespace slipstream
#else
  GpuBand bands[most_bands];
  GpuLink chain[most_bands];
  int words[];
};
#endif
