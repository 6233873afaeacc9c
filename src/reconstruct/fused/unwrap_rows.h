#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/fused/rows.h"
#include "reconstruct/fused/stage_numbers.h"

namespace slipstream {

/// Coordinates of a single frequency. In the fused pass point_row computes them itself.
void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate);

/// Coordinates of pixels with any of the flags `hidden` are NaN, so that they confirm no neighbour.
struct UnwrappedRow {
  int width = 0;
  float* coordinate = nullptr;
  std::int32_t* flags = nullptr;
  std::int32_t hidden = 0;
  float* doubt = nullptr;    ///< see BasicMaps; may be null
  bool keeps_doubt = false;  ///< keeps the larger of this doubt and an earlier step's
};

/// Coordinates from two frequencies. Adds `doubtful_order` to the flags.
void unwrap_row(const UnwrapStage& stage, const float* high_turn, const float* low_turn,
                const UnwrappedRow& row);

/// Coordinates nearest to `near` at which a band of this many periods has these turns.
void place_near(float periods, int width, const float* turn, const float* near, float* coordinate);

/// Wrapped phase in [0, 2 pi), from turns.
void phase_row(int width, const float* turn, float* phase);

/// From the bits of a Code to a coordinate.
struct CodeStage : CodeNumbers {
  std::vector<int> frames{};        ///< one per bit, most significant first; at least one
  std::vector<int> inverses{};      ///< their inverses; empty: compare with the row's reference
  bool alone = false;               ///< Unwrapping::code_alone; else no member below counts
  std::vector<int> rest{};          ///< frames other than bits
  std::vector<int> first_pixels{};  ///< of each stripe that the bits can show, and one more
  float pixels = 0;                 ///< of the projector, across the field
  float largest_doubt = 0.25F;
  float tolerance = 0;       ///< bits nearer to the threshold are doubtful, grey levels of 255
  float least_contrast = 0;  ///< pixels of less are dark, grey levels of 255
};

/// Coordinate of the middle of each pixel's stripe; of a code alone, of all stripes that its
/// doubtful bits allow. `reference`: grey level above which a bit is bright, for each pixel; null
/// if there are inverse frames, or if it is half way between the darkest and the brightest bit.
/// `contrast`: of a code alone, see CodeReading; may be null. `grey_level`: one of 255.
void code_row(const CodeStage& stage, float grey_level, const FrameRows& frames,
              const float* reference, float* contrast, const UnwrappedRow& row);

}  // namespace slipstream
