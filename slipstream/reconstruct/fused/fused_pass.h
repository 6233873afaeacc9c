#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/reconstruct/fused/fused_engine.h"

namespace slipstream {

/// Before the first and after the last coordinate of a row stand NaN, which confirm no neighbour.
inline constexpr int row_padding = least_row_width;

/// Where what is written would push out of the cache what is read, and rows start at whole vectors
/// or at halves of the widest.
inline bool written_past_cache(Size size) {
  constexpr int cached_pixels = 2'000'000;
  return size.width % (least_row_width / 2) == 0 &&
         std::int64_t{size.width} * size.height > cached_pixels;
}

/// One scan on its way through the stages.
template <class Pixel>
struct FusedPass {
  const FusedStages& stages;
  const Frames<Pixel>& frames;
  const Outputs& output;
  double full_scale;
  const std::vector<SinusoidLimits>& limits;  ///< of each band
  CueLimits cue_limits;
  bool past_cache;
  const Image<float>* coarse;  ///< where it is given

  [[nodiscard]] int width() const { return frames.front().width(); }
  [[nodiscard]] int height() const { return frames.front().height(); }

  const Pixel* const* frame_rows(int row, FusedScratch& scratch) const {
    auto& rows = std::get<std::vector<const Pixel*>>(scratch.frames);
    std::transform(frames.begin(), frames.end(), rows.begin(),
                   [row](const auto& frame) { return frame.row(row); });
    return rows.data();
  }

  /// Where the mean goes: grey levels of the frames in a map, of 8 bits in a cloud.
  float* mean_row(int row, FusedScratch& scratch) const {
    if (output.maps != nullptr) return output.maps->mean.row(row);
    if (output.cloud != nullptr) return output.cloud->intensity.row(row);
    // Rows ahead of the points' own are kept where they will be packed.
    const bool runs_ahead = !stages.chain.empty() || stages.cue;
    if (output.points != nullptr && runs_ahead) return output.points->intensity.row(row);
    return scratch.mean.begin();
  }

  [[nodiscard]] float* modulation_row(int row) const {
    if (output.maps != nullptr) return output.maps->modulation.row(row);
    return output.modulation != nullptr ? output.modulation->row(row) : nullptr;
  }

  /// Frames of one row to the turns of every band, and to flags and levels.
  void decode(int row, FusedScratch& scratch, SinusoidRow to) const {
    const Pixel* const* rows = frame_rows(row, scratch);
    for (std::size_t i = 0; i < stages.bands.size(); ++i) {
      const FusedStages::BandStage& band = stages.bands[i];
      to.turn = scratch.turns.row(static_cast<int>(i));
      to.another = i > 0;
      decode_row(band.sinusoid, limits[i], rows + band.first_frame, to);
    }
  }

  /// What a row of the maps gets besides mean, modulation and coordinate, and the cloud from them.
  void finish_maps(int row, const float* turn) const {
    if (output.maps == nullptr) return;
    phase_row(width(), turn, output.maps->wrapped_phase.row(row));
    if (output.cloud == nullptr) return;
    const auto to_8_bits = static_cast<float>(255 / full_scale);
    std::transform(output.maps->mean.row(row), output.maps->mean.row(row) + width(),
                   output.cloud->intensity.row(row), [&](float mean) { return to_8_bits * mean; });
  }

  [[nodiscard]] PointRow point_output(int row, FusedScratch& scratch) const {
    PointRow points{.width = width(),
                    .E_x = stages.rays.E_x.row(row),
                    .E_y = stages.rays.E_y.row(row),
                    .z = scratch.z.begin(),
                    .validity = scratch.validity.begin()};
    if (stages.blocks) points.blocks = stages.blocks->at(row);
    if (output.cloud != nullptr) {
      points.x = output.cloud->x.row(row);
      points.y = output.cloud->y.row(row);
      points.z = output.cloud->z.row(row);
      points.validity = output.cloud->validity.row(row);
    } else if (output.depth != nullptr) {
      points.z = output.depth->z.row(row);
      points.validity = output.depth->validity.row(row);
    } else if (output.points != nullptr) {
      points.x = scratch.x.begin();
      points.y = scratch.y.begin();
    }
    points.past_cache = output.depth16 == nullptr && output.points == nullptr &&
                        written_past_cache(stages.rays.E_x.size());
    return points;
  }

  /// `first`: of the band's rows.
  void finish_points(int first, int row, FusedScratch& scratch) const {
    if (output.depth16 != nullptr) {
      number_row(output.scale, width(), scratch.z.begin(), output.depth16->row(row));
    }
    if (output.points == nullptr) return;
    PackedPoints& to = *output.points;
    const auto at = [&](Image<float>& image) { return image.row(first) + scratch.packed; };
    scratch.packed += pack_row(
        width(), {scratch.x.begin(), scratch.y.begin(), scratch.z.begin(), mean_row(row, scratch)},
        {at(to.x), at(to.y), at(to.z), at(to.intensity)},
        static_cast<std::size_t>(width() * (row + 1 - first)) - scratch.packed);
  }
};

inline float* coordinates(FusedScratch::Row& row) {
  return row.coordinate.begin() + row_padding;
}

/// Points of a row whose neighbours confirm it; `coordinates(row)` are padded on both sides.
template <class Pixel, class Coordinates>
void confirmed_row(const FusedPass<Pixel>& pass, int first, int row, const std::int32_t* flags,
                   const Coordinates& coordinates, FusedScratch& scratch) {
  PointRow points = pass.point_output(row, scratch);
  points.flags = flags;
  points.above = coordinates(row - 1);
  points.coordinate = coordinates(row);
  points.below = coordinates(row + 1);
  point_row(pass.stages.point, pass.stages.consensus, points);
  pass.finish_points(first, row, scratch);
}

/// Block by block, of frames with a cue: what the vote needs to see is decoded, then it is held,
/// then come the points.
template <class Pixel>
void voted_band(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch);

}  // namespace slipstream
