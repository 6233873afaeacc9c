#include "slipstream/reconstruct/fused/fused_engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/reconstruct/fused/fused_pass.h"

namespace slipstream {
namespace {

constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

void prepare(FusedScratch::Row& row, int width) {
  prepare(row.coordinate, {width + 2 * row_padding, 1});
  std::fill(row.coordinate.begin(), row.coordinate.end(), std::numeric_limits<float>::quiet_NaN());
  prepare(row.flags, {width, 1});
}

void prepare(FusedScratch& scratch, int width, const FusedStages& stages) {
  const Size turns{width, static_cast<int>(stages.bands.size())};
  if (scratch.turns.size() != turns) {
    for (FusedScratch::Row& row : scratch.rows) prepare(row, width);
    prepare(scratch.turns, turns);
    prepare(scratch.unwrapped, {width, 2});
    for (Image<float>* row :
         {&scratch.sum, &scratch.coarse, &scratch.mean, &scratch.x, &scratch.y, &scratch.z}) {
      prepare(*row, {width, 1});
    }
    prepare(scratch.validity, {width, 1});
  }
  scratch.packed = 0;
  std::apply([&](auto&... rows) { (rows.resize(index(stages.frames)), ...); }, scratch.frames);
}

/// Puts NaN where a pixel has one of those flags.
void hide(int width, const std::int32_t* flags, std::int32_t hidden, float* values) {
  for (int i = 0; i < width; ++i) {
    if ((flags[i] & hidden) != 0) values[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

template <class Pixel>
void one_band(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
  float* turn = scratch.turns.begin();
  std::int32_t* flags = scratch.rows[0].flags.begin();
  Maps* const maps = pass.output.maps;
  for (int row = first; row < last; ++row) {
    pass.decode(row, scratch,
                {.width = pass.width(),
                 .mean = pass.mean_row(row, scratch),
                 .modulation = pass.modulation_row(row),
                 .flags = flags,
                 .past_cache = pass.past_cache,
                 .only_lit = maps == nullptr,
                 .nan_if_flagged = maps == nullptr});
    if (maps != nullptr) {
      place_row(pass.stages.coordinate, pass.width(), turn, maps->coordinate.row(row));
      pass.finish_maps(row, turn);
      hide(pass.width(), flags, PixelFlag::dark | PixelFlag::saturated, turn);
    }
    if (!pass.output.makes_points()) continue;
    PointRow points = pass.point_output(row, scratch);
    points.flags = flags;
    points.coordinate = turn;
    point_row(pass.stages.point, pass.stages.coordinate, points);
    pass.finish_points(first, row, scratch);
  }
}

/// The turns of a sum of bands: of one band its own row, else in `to`.
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

/// The middle of each pixel's stripe. `mean`: a row of the first band's, in the output's levels.
template <class Pixel>
const float* code_coordinates(const FusedPass<Pixel>& pass, int row, const float* mean,
                              FusedScratch& scratch) {
  const FusedStages::CodeBits& code = *pass.stages.code;
  const Pixel* const* const frames = pass.frame_rows(row, scratch);
  const int width = pass.width();
  float* const limit = scratch.sum.begin();
  if (code.against_mean) {
    const float to_frames = 1 / (pass.limits.front().mean_scale *
                                 static_cast<float>(pass.stages.bands.front().sinusoid.steps));
    for (int i = 0; i < width; ++i) limit[i] = to_frames * mean[i];
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

/// What the chain begins with: turns, or coordinates.
template <class Pixel>
const float* coarse_row(const FusedPass<Pixel>& pass, int row, const float* mean,
                        FusedScratch& scratch) {
  const FusedStages& stages = pass.stages;
  if (pass.coarse != nullptr) return pass.coarse->row(row);
  if (stages.code) return code_coordinates(pass, row, mean, scratch);
  float* const coarse = scratch.coarse.begin();
  if (!stages.coarse_in_field) return sum_row(stages.coarse, pass.width(), scratch, coarse);
  const float* const turns = sum_row(stages.coarse, pass.width(), scratch, scratch.sum.begin());
  place_row(stages.coarse_stage, pass.width(), turns, coarse);
  return coarse;
}

/// The coordinates of all bands weighed, at the fringe orders next to `y`, in place.
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

/// Turns of all bands to coordinates, along the chain. Where `maps` are wanted of the row they get
/// the coordinates of dark pixels too.
template <class Pixel>
void unwrap_bands(const FusedPass<Pixel>& pass, int row, const float* mean, FusedScratch& scratch,
                  FusedScratch::Row& kept, Maps* maps) {
  const auto& chain = pass.stages.chain;
  const int width = pass.width();
  float* const doubt = maps != nullptr ? maps->fringe_order_doubt.row(row) : nullptr;
  std::int32_t* const flags = kept.flags.begin();
  float* const y = maps != nullptr ? maps->coordinate.row(row) : coordinates(kept);
  const float* coarse = coarse_row(pass, row, mean, scratch);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const bool last = i + 1 == chain.size(), hides = last && maps == nullptr;
    float* const to = last ? y : scratch.unwrapped.row(static_cast<int>(i % 2));
    unwrap_row(chain[i].unwrap, width, sum_row(chain[i].of, width, scratch, scratch.sum.begin()),
               coarse, hides ? PixelFlag::dark : 0,
               {.coordinate = to, .flags = flags, .doubt = doubt, .keeps_doubt = i > 0});
    coarse = to;
  }
  if (pass.stages.weighs_bands) weigh_bands(pass.stages, width, scratch, y);
  if (maps == nullptr) return;
  std::copy_n(y, width, coordinates(kept));
  hide(width, flags, PixelFlag::dark, coordinates(kept));
}

/// The coordinates of each row are kept until those below it are known, for its neighbours confirm
/// them.
template <class Pixel>
void several_bands(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
  const auto kept = [&](int row) -> FusedScratch::Row& { return scratch.rows[index(row + 3) % 3]; };
  const auto decode = [&](int row) {
    if (row < 0 || row >= pass.height()) return prepare(kept(row), pass.width());
    const bool ours = row >= first && row < last;
    Maps* const maps = ours ? pass.output.maps : nullptr;
    float* const mean = ours ? pass.mean_row(row, scratch) : scratch.mean.begin();
    pass.decode(row, scratch,
                {.width = pass.width(),
                 .mean = mean,
                 .modulation = ours ? pass.modulation_row(row) : nullptr,
                 .flags = kept(row).flags.begin(),
                 .past_cache = ours && pass.past_cache && !pass.stages.code,
                 .only_lit = maps == nullptr});
    unwrap_bands(pass, row, mean, scratch, kept(row), maps);
    if (maps != nullptr) pass.finish_maps(row, scratch.turns.begin());
  };
  if (!pass.output.makes_points()) {
    for (int row = first; row < last; ++row) decode(row);
    return;
  }
  decode(first - 1);
  decode(first);
  for (int row = first; row < last; ++row) {
    decode(row + 1);
    confirmed_row(
        pass, first, row, kept(row).flags.begin(),
        [&](int near) { return coordinates(kept(near)); }, scratch);
  }
}

template <class Pixel>
void run_band(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
  if (pass.stages.cue) return voted_band(pass, first, last, scratch);
  if (!pass.stages.chain.empty()) return several_bands(pass, first, last, scratch);
  one_band(pass, first, last, scratch);
}

/// Bands so high that the rows decoded twice at their borders do not matter, and several for each
/// thread so that none waits long.
int band_count(int height, bool votes) {
  constexpr int bands_per_thread = 4;
  const int fewest_rows = votes ? 4 * 2 * VoteBlock::seen : 32;
  const int threads = parallel_threads();
  return threads == 1 ? 1 : std::clamp(height / fewest_rows, 1, bands_per_thread * threads);
}

std::array<Image<float>*, 4> values_of(PackedPoints& points) {
  return {&points.x, &points.y, &points.z, &points.intensity};
}

/// All bands of a scan, on as many threads as there are.
template <class Pixel>
void run_bands(const FusedPass<Pixel>& pass, std::vector<FusedScratch>& scratch) {
  const int bands = band_count(pass.height(), pass.stages.cue.has_value());
  if (scratch.size() < index(bands)) scratch.resize(index(bands));

  // One captured reference: std::function then allocates nothing.
  struct Work {
    const FusedPass<Pixel>& pass;
    std::vector<FusedScratch>& scratch;
    int bands;
    [[nodiscard]] int border(int i) const {
      return static_cast<int>(std::int64_t{pass.height()} * i / bands);
    }
    void operator()(int band) const {
      prepare(scratch[index(band)], pass.width(), pass.stages);
      run_band(pass, border(band), border(band + 1), scratch[index(band)]);
      flush_past_cache();
    }
  };
  const Work work{pass, scratch, bands};
  if (bands == 1) {
    work(0);
  } else {
    for_each_row(bands, [&work](int band) { work(band); });
  }
  if (PackedPoints* const points = pass.output.points) {
    points->count = 0;
    for (int band = 0; band < bands; ++band) {
      const std::size_t count = scratch[index(band)].packed;
      for (Image<float>* values : values_of(*points)) {
        std::copy_n(values->row(work.border(band)), count, values->begin() + points->count);
      }
      points->count += count;
    }
  }
}

}  // namespace

void prepare(const Outputs& output, Size size, bool doubtful) {
  if (output.cloud != nullptr) {
    Cloud& cloud = *output.cloud;
    for (Image<float>* image : {&cloud.x, &cloud.y, &cloud.z, &cloud.intensity}) {
      prepare(*image, size);
    }
    prepare(cloud.validity, size);
  }
  if (output.depth != nullptr) {
    prepare(output.depth->z, size);
    prepare(output.depth->validity, size);
  }
  if (output.points != nullptr) {
    for (Image<float>* image : values_of(*output.points)) prepare(*image, size);
  }
  if (output.maps != nullptr) {
    Maps& maps = *output.maps;
    for (Image<float>* image :
         {&maps.mean, &maps.modulation, &maps.wrapped_phase, &maps.coordinate}) {
      prepare(*image, size);
    }
    prepare(maps.fringe_order_doubt, doubtful ? size : Size{});
  }
  if (output.modulation != nullptr) prepare(*output.modulation, size);
  if (output.depth16 != nullptr) prepare(*output.depth16, size);
}

void require_frames(const FrameViews& frames, int count, Size camera) {
  if (frames.count() != count) {
    throw Error(fmt::format("{} frames given; the strategy takes {}", frames.count(), count));
  }
  if (frames.size() != camera) {
    throw Error(fmt::format("frames are {}, the scanner's camera has {}; both must agree",
                            text_of(frames.size()), text_of(camera)));
  }
}

FusedEngine::FusedEngine(FusedStages stages, ReconstructSettings settings)
    : stages_(std::move(stages)), settings_(std::move(settings)) {}

std::optional<FusedEngine> FusedEngine::make(const EngineSetup& setup,
                                             const PhaseCorrections& corrections) {
  std::optional<FusedStages> stages = fused_stages(setup, corrections);
  if (!stages) return std::nullopt;
  return FusedEngine(std::move(*stages), setup.settings);
}

void FusedEngine::operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                             const Image<float>* coarse) const {
  if ((coarse != nullptr) != stages_.coarse_given) {
    throw Error("a coordinate is given where, and only where, the picture gives the fringe order");
  }
  require_frames(frames, stages_.frames, stages_.rays.E_x.size());
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      const Size size = stages_.rays.E_x.size();
      const double full_scale = frames.full_scale();
      const double mean_of = output.maps != nullptr ? 1 : 255 / full_scale;
      memory.limits.clear();
      for (const FusedStages::BandStage& band : stages_.bands) {
        memory.limits.push_back(
            sinusoid_limits(band.sinusoid, settings_, full_scale, frames.saturation(), mean_of));
      }
      prepare(output, size, !stages_.chain.empty() || stages_.cue);
      const FusedPass<Pixel> pass{
          .stages = stages_,
          .frames = views,
          .output = output,
          .full_scale = full_scale,
          .limits = memory.limits,
          .cue_limits = stages_.cue ? cue_limits(stages_, settings_, full_scale) : CueLimits{},
          .past_cache =
              output.cloud != nullptr && output.maps == nullptr && written_past_cache(size),
          .coarse = coarse};
      run_bands(pass, memory.scratch);
    } else {
      throw Error("frames are not quantised; the fused pass takes 8 to 16 bits");
    }
  });
}

}  // namespace slipstream
