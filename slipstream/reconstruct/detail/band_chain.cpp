#include "slipstream/reconstruct/detail/band_chain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace slipstream {

const float* sum_row(const std::vector<int>& of, int width, FusedScratch& scratch, float* to) {
  const auto alone = std::find(of.begin(), of.end(), 1);
  if (std::count(of.begin(), of.end(), 0) + 1 == static_cast<std::ptrdiff_t>(of.size()) &&
      alone != of.end()) {
    return scratch.turns.row(static_cast<int>(alone - of.begin()));
  }
  std::fill_n(to, width, 0.0F);
  for (std::size_t band = 0; band < of.size(); ++band) {
    const float* const turn = scratch.turns.row(static_cast<int>(band));
    const auto factor = static_cast<float>(of[band]);
    if (factor == 0) continue;
    for (int i = 0; i < width; ++i) to[i] += factor * turn[i];
  }
  for (int i = 0; i < width; ++i) to[i] -= std::floor(to[i]);
  return to;
}

const float* first_of_chain(const FusedStages& stages, int width, FusedScratch& scratch) {
  float* const coarse = scratch.coarse.begin();
  if (!stages.coarse_in_field) return sum_row(stages.coarse, width, scratch, coarse);
  const float* const turns = sum_row(stages.coarse, width, scratch, scratch.sum.begin());
  place_row(stages.coarse_stage, width, turns, coarse);
  return coarse;
}

template <class Pixel>
const float* code_coordinates(const FusedStages::CodeBits& code, const Pixel* const* frames,
                              int width, const CodeLevels& levels, FusedScratch& scratch) {
  float* const limit = scratch.sum.begin();
  if (code.against_mean) {
    for (int i = 0; i < width; ++i) limit[i] = levels.mean_to_frames * levels.mean[i];
  } else {
    std::fill_n(limit, width, 0.0F);
    for (std::size_t n = 0; n < code.reference.size(); ++n) {
      if (code.reference[n] == 0) continue;
      for (int i = 0; i < width; ++i) {
        limit[i] += code.reference[n] * static_cast<float>(frames[n][i]);
      }
    }
  }
  code_row(code.stage, width, frames, limit, scratch.coarse.begin());
  return scratch.coarse.begin();
}

template const float* code_coordinates(const FusedStages::CodeBits&, const std::uint8_t* const*,
                                       int, const CodeLevels&, FusedScratch&);
template const float* code_coordinates(const FusedStages::CodeBits&, const std::uint16_t* const*,
                                       int, const CodeLevels&, FusedScratch&);

void weigh_bands(const FusedStages& stages, int width, FusedScratch& scratch, float* y) {
  float *const other = scratch.sum.begin(), *const sum = scratch.coarse.begin();
  std::copy_n(y, width, sum);
  for (std::size_t band = 1; band < stages.bands.size(); ++band) {
    const auto& [sinusoid, first_frame, periods, weight] = stages.bands[band];
    if (weight == 0) continue;
    place_near(static_cast<float>(periods), width, scratch.turns.row(static_cast<int>(band)), y,
               other);
    for (int i = 0; i < width; ++i) sum[i] += weight * (other[i] - y[i]);
  }
  if (stages.coarse_in_field) {
    std::copy_n(sum, width, y);
  } else {
    const auto& [scale, period, cut] = stages.coordinate;
    place_row({.scale = 1, .period = period, .cut = cut}, width, sum, y);
  }
}

}  // namespace slipstream
