#include "reconstruct/fused/fused_engine.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_band.h"

namespace slipstream {
namespace {

void prepare(FusedScratch& scratch, int width, const FusedStages& stages) {
  const Size turns{width, static_cast<int>(stages.bands.size())};
  if (scratch.turns.size() != turns) {
    const auto rows_of = [&](auto&... rows) { (prepare(rows, {width, 1}), ...); };
    scratch.kept.prepare(width, 4);
    prepare(scratch.turns, turns);
    prepare(scratch.modulations, turns);
    prepare(scratch.unwrapped, {width, 2});
    rows_of(scratch.sum, scratch.coarse, scratch.mean, scratch.x, scratch.y, scratch.z,
            scratch.validity);
  }

  scratch.packed = 0;
  std::apply([&](auto&... rows) { (rows.resize(index(stages.frames)), ...); }, scratch.frames);
}

/// Number of bands: high enough that rows decoded twice at their borders cost little, and several
/// per thread so that none waits long.
int band_count(int height, bool votes) {
  constexpr int bands_per_thread = 4;

  // The vote decodes `seen` more rows on either side of a band: at most a quarter of its rows.
  const int fewest_rows = votes ? 4 * 2 * VoteBlock::seen : 32;
  const int threads = parallel_threads();

  return threads == 1 ? 1 : std::clamp(height / fewest_rows, 1, bands_per_thread * threads);
}

void run_bands(const FusedPass& pass, std::vector<FusedScratch>& scratch) {
  const int bands = band_count(pass.height(), pass.stages.cue.has_value());
  if (scratch.size() < index(bands)) scratch.resize(index(bands));

  // In 64 bits: rows times bands may not fit into an int.
  const auto border = [&](int i) {
    return static_cast<int>(std::int64_t{pass.height()} * i / bands);
  };

  const auto work = [&](int band) {
    prepare(scratch[index(band)], pass.width(), pass.stages);
    run_band({pass, border(band), border(band + 1), scratch[index(band)]});
    flush_past_cache();
  };

  if (bands == 1) {
    work(0);
  } else {  // a single captured reference, so that std::function does not allocate
    for_each_row(bands, [&work](int band) { work(band); });
  }

  // Each band has packed its points from its own first row on. Close the gaps between them.
  if (PackedPoints* const points = pass.output.points) {
    points->count = 0;
    for (int band = 0; band < bands; ++band) {
      const std::size_t count = scratch[index(band)].packed;
      for (Image<float>* values : {&points->x, &points->y, &points->z, &points->intensity}) {
        std::copy_n(values->row(border(band)), count, values->begin() + points->count);
      }
      points->count += count;
    }
  }
}

}  // namespace

void prepare(const Outputs& output, Size size, bool doubtful) {
  const auto all = [&](auto&... images) { (prepare(images, size), ...); };

  if (Cloud* const cloud = output.cloud) {
    all(cloud->x, cloud->y, cloud->z, cloud->intensity, cloud->validity);
  }

  if (Depth* const depth = output.depth) all(depth->z, depth->validity);

  if (PackedPoints* const points = output.points) {
    all(points->x, points->y, points->z, points->intensity);
  }

  if (Maps* const maps = output.maps) {
    all(maps->mean, maps->modulation, maps->wrapped_phase, maps->coordinate);
    prepare(maps->fringe_order_doubt, doubtful ? size : Size{});
  }

  if (output.modulation != nullptr) all(*output.modulation);
  if (output.depth16 != nullptr) all(*output.depth16);
}

void require_frames(const FrameViews& frames, int count, Size camera) {
  throw_if(frames.count() != count, "{} frames given; the strategy takes {}", frames.count(),
           count);
  require_size(frames, camera);
}

std::optional<FusedEngine> FusedEngine::make(const EngineSetup& setup,
                                             const PhaseCorrections& corrections,
                                             std::string* why_not) {
  std::optional<FusedStages> stages = fused_stages(setup, corrections, why_not);

  if (!stages) return std::nullopt;
  return FusedEngine{std::make_shared<const FusedStages>(std::move(*stages)), setup.settings};
}

void FusedEngine::find_limits(const FrameViews& frames, const Outputs& output,
                              std::vector<SinusoidLimits>& limits) const {
  const double full_scale = frames.full_scale();
  const double mean_of = output.maps != nullptr ? 1 : 255 / full_scale;

  limits.clear();
  for (const FusedStages::BandStage& band : stages->bands) {
    limits.push_back(
        sinusoid_limits(band.sinusoid, settings, full_scale, frames.saturation(), mean_of));

    // A code has limits of its own.
    if (stages->reads_stripes()) limits.back() = {.mean_scale = limits.back().mean_scale};
  }
}

void FusedEngine::operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                             const Image<float>* coarse) const {
  throw_if(
      (coarse != nullptr) != stages->coarse_given,
      "coarse coordinates are required if, and only if, the whole image gives the fringe order");

  const Size size = stages->rays.E_x.size();
  require_frames(frames, stages->frames, size);
  throw_if(!frames.quantised(), "frames are not quantised; the fused pass takes 8 to 16 bits");

  find_limits(frames, output, memory.limits);
  prepare(output, size, stages->has_doubt());

  const bool past_cache =
      output.cloud != nullptr && output.maps == nullptr && written_past_cache(size);

  run_bands(
      {.stages = *stages,
       .frames = frames,
       .output = output,
       .limits = memory.limits,
       .cue_limits = stages->cue ? cue_limits(*stages, settings, frames.full_scale()) : CueLimits{},
       .past_cache = past_cache,
       .coarse = coarse},
      memory.scratch);
}

}  // namespace slipstream
