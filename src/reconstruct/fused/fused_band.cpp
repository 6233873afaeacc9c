#include "reconstruct/fused/fused_band.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "reconstruct/fused/order_rows.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/unwrap_rows.h"

namespace slipstream {
namespace {

/// Sets values to NaN where a pixel has any of the flags `hidden`.
void hide(int width, const std::int32_t* flags, std::int32_t hidden, float* values) {
  for (int i = 0; i < width; ++i) {
    if ((flags[i] & hidden) != 0) values[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

void one_band(const FusedBand& band) {
  KeptRows& kept = band.scratch.kept;
  float* const turn = band.scratch.turns.begin();
  Maps* const maps = band.output.maps;

  for (int row = band.first; row < band.last; ++row) {
    std::int32_t* const flags = kept.flags(row);

    band.decode(row, {.width = band.width(),
                      .mean = band.mean_row(row),
                      .modulation = band.modulation_row(row),
                      .flags = flags,
                      .past_cache = band.past_cache,
                      .only_lit = maps == nullptr,
                      .nan_if_flagged = maps == nullptr});

    // Maps keep the turns of dark and saturated pixels, so these are hidden only now.
    if (maps != nullptr) {
      place_row(band.stages.coordinate, band.width(), turn, maps->coordinate.row(row));
      band.finish_maps(row, turn);
      hide(band.width(), flags, PixelFlag::dark | PixelFlag::saturated, turn);
    }

    if (band.output.makes_points()) band.finish_points(row, kept, turn);
  }
}

/// Turns of a sum of bands: its own row for a single band, else `to`.
const float* sum_row(const std::vector<int>& of, int width, FusedScratch& scratch, float* to) {
  if (of.empty()) return scratch.turns.begin();

  // One band with the factor 1 and no other: its own turns.
  const auto alone = std::find(of.begin(), of.end(), 1);
  if (std::count(of.begin(), of.end(), 0) + 1 == static_cast<std::ptrdiff_t>(of.size()) &&
      alone != of.end()) {
    return scratch.turns.row(static_cast<int>(alone - of.begin()));
  }

  // Otherwise a sum, such as a beat, brought back to [0, 1) turns.
  std::fill_n(to, width, 0.0F);
  for (std::size_t band = 0; band < of.size(); ++band) {
    const float* const turn = scratch.turns.row(static_cast<int>(band));
    const auto factor = static_cast<float>(of[band]);
    if (factor == 0) continue;
    for (int i = 0; i < width; ++i) to[i] += factor * turn[i];
  }

  place_row(placing(1, 1, 0), width, to, to);
  return to;
}

/// Level above which the bits of each pixel are bright; null if a code needs none. `mean`: row of
/// the measuring band, in levels of the output.
const float* bright_levels(const FusedBand& band, int row, const float* mean) {
  const FusedStages::CodeBits& code = *band.stages.code;
  const int width = band.width();
  float* const limit = band.scratch.sum.begin();
  if (!code.against_mean && code.reference.empty()) return nullptr;

  // The mean has been decoded already, and is only scaled back to levels of the frames.
  if (code.against_mean) {
    const float to_frames = 1 / (band.limits.front().mean_scale *
                                 static_cast<float>(band.stages.bands.front().sinusoid.steps));
    for (int i = 0; i < width; ++i) limit[i] = to_frames * mean[i];
  } else {
    std::fill_n(limit, width, 0.0F);
    band.frames.visit([&](const auto& frames) {
      for (std::size_t n = 0; n < code.reference.size(); ++n) {
        if (code.reference[n] == 0) continue;
        const auto* const level = frames[n].row(row);
        for (int i = 0; i < width; ++i)
          limit[i] += code.reference[n] * static_cast<float>(level[i]);
      }
    });
  }

  return limit;
}

void read_code(const FusedBand& band, int row, const SinusoidRow& decoded, const UnwrappedRow& to) {
  code_row(band.stages.code->stage, static_cast<float>(band.frames.full_scale() / 255),
           band.frame_rows(row), bright_levels(band, row, decoded.mean), decoded.modulation, to);
}

/// Start of the chain: turns or coordinates.
const float* coarse_row(const FusedBand& band, int row, const SinusoidRow& decoded) {
  const auto& [stages, scratch] = std::tie(band.stages, band.scratch);
  if (band.coarse != nullptr) return band.coarse->row(row);

  float* const coarse = scratch.coarse.begin();
  if (stages.code) {
    read_code(band, row, decoded,
              {.width = band.width(), .coordinate = coarse, .flags = decoded.flags});
    return coarse;
  }

  // The coarsest band: as turns if the chain is circular, else placed in the field.
  if (!stages.coarse_in_field) return sum_row(stages.coarse, band.width(), scratch, coarse);

  const float* const turns = sum_row(stages.coarse, band.width(), scratch, scratch.sum.begin());
  place_row(stages.coarse_stage, band.width(), turns, coarse);
  return coarse;
}

/// Replaces `y` by the weighted mean over all bands, at the fringe orders nearest to it.
void weigh_bands(const FusedStages& stages, int width, FusedScratch& scratch, float* y) {
  float *const other = scratch.sum.begin(), *const sum = scratch.coarse.begin();
  std::copy_n(y, width, sum);

  // The weights sum to 1, so each band moves y by its weight times its distance from y.
  for (std::size_t band = 1; band < stages.bands.size(); ++band) {
    const auto& [sinusoid, first_frame, periods, weight] = stages.bands[band];
    if (weight == 0) continue;
    place_near(static_cast<float>(periods), width, scratch.turns.row(static_cast<int>(band)), y,
               other);

    for (int i = 0; i < width; ++i) sum[i] += weight * (other[i] - y[i]);
  }

  // In a circular chain the mean may have left the field.
  if (stages.coarse_in_field) {
    std::copy_n(sum, width, y);
  } else {
    place_row(placing(1, stages.coordinate.period, stages.coordinate.cut), width, sum, y);
  }
}

/// Converts turns of all bands to coordinates, along the chain. `maps`, unless null, also get the
/// coordinates of dark pixels.
void unwrap_bands(const FusedBand& band, int row, const SinusoidRow& decoded, Maps* maps) {
  FusedScratch& scratch = band.scratch;
  const auto& chain = band.stages.chain;
  const int width = band.width();

  // 1. The outputs. Maps keep the coordinates of dark pixels; without maps these are NaN at once,
  // so that they confirm no neighbour.
  float *const doubt = maps != nullptr && band.stages.has_doubt()
                           ? maps->fringe_order_doubt.row(row)
                           : nullptr,
               *const kept = scratch.kept.coordinates(row);
  float* const y = maps != nullptr ? maps->coordinate.row(row) : kept;
  const std::int32_t hidden = maps == nullptr ? PixelFlag::dark : 0;

  UnwrappedRow to{
      .width = width, .coordinate = y, .flags = decoded.flags, .hidden = hidden, .doubt = doubt};

  // 2. Start: the best of all fringe orders, a code alone, or the coarsest coordinate.
  if (const auto& orders = band.stages.orders) {
    if (band.stages.weighs_modulations()) {
      likelihood_row(*orders, scratch.turns, scratch.modulations, to);
    } else {
      fit_row(*orders, band.limits.front(), band.frame_rows(row), scratch.turns.begin(), to);
    }
  }
  if (band.stages.reads_stripes()) read_code(band, row, decoded, to);
  const float* coarse = chain.empty() ? nullptr : coarse_row(band, row, decoded);

  // 3. Climb the chain: each link unwraps its turns by the result of the one before, in two rows
  // used in turn.
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const bool last = i + 1 == chain.size();
    to.coordinate = last ? y : scratch.unwrapped.row(static_cast<int>(i % 2));
    to.hidden = last ? hidden : 0;
    to.keeps_doubt = i > 0;
    unwrap_row(chain[i].unwrap, sum_row(chain[i].of, width, scratch, scratch.sum.begin()), coarse,
               to);
    coarse = to.coordinate;
  }

  // 4. Weigh all bands, and keep the row for the neighbours.
  if (band.stages.weighs_bands) weigh_bands(band.stages, width, scratch, y);
  if (maps == nullptr) return;
  std::copy_n(y, width, kept);
  hide(width, decoded.flags, PixelFlag::dark, kept);
}

/// Keeps the coordinates of each row until the next row is known, since neighbours confirm them.
void several_bands(const FusedBand& band) {
  KeptRows& kept = band.scratch.kept;

  const auto decode = [&](int row) {
    if (row < 0 || row >= band.height()) return kept.clear(row, row + 1);

    // Rows beyond the band's borders are decoded for their neighbours, and write no output.
    const bool ours = row >= band.first && row < band.last;
    Maps* const maps = ours ? band.output.maps : nullptr;

    const SinusoidRow decoded{.width = band.width(),
                              .mean = ours ? band.mean_row(row) : band.scratch.mean.begin(),
                              .modulation = ours ? band.modulation_row(row) : nullptr,
                              .flags = kept.flags(row),
                              .past_cache = ours && band.past_cache && !band.stages.code,
                              .only_lit = maps == nullptr};

    band.decode(row, decoded);
    unwrap_bands(band, row, decoded, maps);

    if (maps == nullptr) return;
    FusedScratch& scratch = band.scratch;
    band.finish_maps(row,
                     sum_row(band.stages.measured, band.width(), scratch, scratch.sum.begin()));
  };

  // Without points, rows need no neighbours.
  if (!band.output.makes_points()) {
    for (int row = band.first; row < band.last; ++row) decode(row);
    return;
  }

  // A row becomes points once the row below it is decoded.
  decode(band.first - 1);
  decode(band.first);
  for (int row = band.first; row < band.last; ++row) {
    decode(row + 1);
    band.finish_points(row, kept);
  }
}

}  // namespace

void run_band(const FusedBand& band) {
  if (band.stages.cue) return voted_band(band);
  if (band.stages.asks_neighbours()) {
    several_bands(band);
  } else {
    one_band(band);
  }
}

FrameRows FusedBand::frame_rows(int row, int column) const {
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) -> FrameRows {
    if constexpr (std::is_integral_v<Pixel>) {
      auto& rows = std::get<std::vector<const Pixel*>>(scratch.frames);
      std::transform(views.begin(), views.end(), rows.begin(),
                     [&](const auto& frame) { return frame.row(row) + column; });
      return rows.data();
    }
    return {};
  });
}

float* FusedBand::mean_row(int row) const {
  if (output.maps != nullptr) return output.maps->mean.row(row);
  if (output.cloud != nullptr) return output.cloud->intensity.row(row);

  // Rows decoded ahead of the points are kept where they will be packed.
  const bool kept = output.points != nullptr && stages.asks_neighbours();
  return kept ? output.points->intensity.row(row) : scratch.mean.begin();
}

float* FusedBand::modulation_row(int row) const {
  if (output.maps != nullptr) return output.maps->modulation.row(row);
  return output.modulation != nullptr ? output.modulation->row(row) : nullptr;
}

void FusedBand::decode(int row, SinusoidRow to) const {
  const FrameRows rows = frame_rows(row);
  for (std::size_t i = 0; i < stages.bands.size(); ++i) {
    const FusedStages::BandStage& band = stages.bands[i];

    to.turn = scratch.turns.row(static_cast<int>(i));
    to.another = i > 0;
    if (stages.weighs_modulations())
      to.own_modulation = scratch.modulations.row(static_cast<int>(i));
    to.limits = limits[i];

    const auto from_first = [&](auto of) -> FrameRows { return of + band.first_frame; };
    decode_row(band.sinusoid, std::visit(from_first, rows), to);
  }
}

void FusedBand::finish_maps(int row, const float* turn) const {
  if (output.maps == nullptr) return;
  phase_row(width(), turn, output.maps->wrapped_phase.row(row));

  if (output.cloud == nullptr) return;
  const auto to_8_bits = static_cast<float>(255 / frames.full_scale());
  const float* const mean = output.maps->mean.row(row);
  std::transform(mean, mean + width(), output.cloud->intensity.row(row),
                 [&](float level) { return to_8_bits * level; });
}

void FusedBand::finish_points(int row, KeptRows& kept, const float* turn) const {
  PointRow to{.width = width(),
              .E_x = stages.rays.E_x.row(row),
              .E_y = stages.rays.E_y.row(row),
              .flags = kept.flags(row),
              .z = scratch.z.begin(),
              .validity = scratch.validity.begin()};

  // 1. Where the points go: into the output, or into a scratch row that is packed below.
  if (stages.blocks) to.blocks = stages.blocks->at(row);
  if (output.cloud != nullptr) {
    to.x = output.cloud->x.row(row);
    to.y = output.cloud->y.row(row);
    to.z = output.cloud->z.row(row);
    to.validity = output.cloud->validity.row(row);
  } else if (output.depth != nullptr) {
    to.z = output.depth->z.row(row);
    to.validity = output.depth->validity.row(row);
  } else if (output.points != nullptr) {
    to.x = scratch.x.begin();
    to.y = scratch.y.begin();
  }

  // Rows that are read again below must stay in the cache.
  to.past_cache = output.depth16 == nullptr && output.points == nullptr &&
                  written_past_cache(stages.rays.E_x.size());

  // 2. Compute the points.
  if (turn != nullptr) {
    to.coordinate = turn;
    point_row(stages.point, stages.coordinate, to);
  } else {
    to.above = kept.coordinates(row - 1);
    to.coordinate = kept.coordinates(row);
    to.below = kept.coordinates(row + 1);
    point_row(stages.point, stages.consensus, to);
  }

  // 3. Convert depths to whole numbers, or pack the pixels that have a point.
  if (output.depth16 != nullptr) number_row(output.scale, width(), to.z, output.depth16->row(row));
  if (output.points == nullptr) return;

  const auto at = [&](Image<float>& image) { return image.row(first) + scratch.packed; };

  PackedPoints& points = *output.points;
  scratch.packed += pack_row(width(), {to.x, to.y, to.z, mean_row(row)},
                             {at(points.x), at(points.y), at(points.z), at(points.intensity)},
                             index(width()) * index(row + 1 - first) - scratch.packed);
}

}  // namespace slipstream
