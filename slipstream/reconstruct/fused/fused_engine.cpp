#include "slipstream/reconstruct/fused/fused_engine.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/reconstruct/detail/band_chain.h"

namespace slipstream {
namespace {

constexpr int padding = least_row_width;
constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Before the first and after the last pixel stands NaN, which confirms no neighbour.
void prepare(FusedScratch::Row& row, int width) {
  prepare(row.coordinate, {width + 2 * padding, 1});
  std::fill(row.coordinate.begin(), row.coordinate.end(), std::numeric_limits<float>::quiet_NaN());
  prepare(row.flags, {width, 1});
}

void prepare(FusedScratch& scratch, int width, const FusedStages& stages) {
  const Size turns{width, static_cast<int>(stages.bands.size())};
  if (scratch.turns.size() != turns) {
    for (FusedScratch::Row& row : scratch.rows) prepare(row, width);
    prepare(scratch.turns, turns);
    prepare(scratch.unwrapped, {width, 2});
    for (Image<float>* row : {&scratch.sum, &scratch.coarse}) prepare(*row, {width, 1});
    for (Image<float>* row : {&scratch.mean, &scratch.x, &scratch.y, &scratch.z}) {
      prepare(*row, {width, 1});
    }
    prepare(scratch.validity, {width, 1});
  }
  scratch.packed = 0;
  std::apply([&](auto&... rows) { (rows.resize(index(stages.frames)), ...); }, scratch.frames);
}

/// Where what is written would push out of the cache what is read, and rows start at whole vectors
/// or at halves of the widest.
bool written_past_cache(Size size) {
  constexpr int cached_pixels = 2'000'000;
  return size.width % (least_row_width / 2) == 0 &&
         std::int64_t{size.width} * size.height > cached_pixels;
}

/// One scan on its way through the stages.
template <class Pixel>
struct Pass {
  const FusedStages& stages;
  const Frames<Pixel>& frames;
  const FusedOutput& output;
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
    points.past_cache = output.numbers == nullptr && output.points == nullptr &&
                        written_past_cache(stages.rays.E_x.size());
    return points;
  }

  /// `first`: of the band's rows.
  void finish_points(int first, int row, FusedScratch& scratch) const {
    if (output.numbers != nullptr) {
      number_row(output.scale, width(), scratch.z.begin(), output.numbers->row(row));
    }
    if (output.points == nullptr) return;
    PackedPoints& to = *output.points;
    const auto at = [&](Image<float>& image) { return image.row(first) + scratch.packed; };
    scratch.packed += pack_row(
        width(), {scratch.x.begin(), scratch.y.begin(), scratch.z.begin(), mean_row(row, scratch)},
        {at(to.x), at(to.y), at(to.z), at(to.intensity)},
        index(width()) * index(row + 1 - first) - scratch.packed);
  }
};

float* coordinates(FusedScratch::Row& row) {
  return row.coordinate.begin() + padding;
}

/// Puts NaN where a pixel has one of those flags.
void hide(int width, const std::int32_t* flags, std::int32_t hidden, float* values) {
  for (int i = 0; i < width; ++i) {
    if ((flags[i] & hidden) != 0) values[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

template <class Pixel>
void one_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
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

/// Points of a row whose neighbours confirm it; `coordinates(row)` are padded on both sides.
template <class Pixel, class Coordinates>
void confirmed_row(const Pass<Pixel>& pass, int first, int row, const std::int32_t* flags,
                   const Coordinates& coordinates, FusedScratch& scratch) {
  PointRow points = pass.point_output(row, scratch);
  points.flags = flags;
  points.above = coordinates(row - 1);
  points.coordinate = coordinates(row);
  points.below = coordinates(row + 1);
  point_row(pass.stages.point, pass.stages.consensus, points);
  pass.finish_points(first, row, scratch);
}

/// What the chain begins with: turns, or coordinates.
template <class Pixel>
const float* coarse_row(const Pass<Pixel>& pass, int row, const float* mean,
                        FusedScratch& scratch) {
  if (pass.coarse != nullptr) return pass.coarse->row(row);
  if (!pass.stages.code) return first_of_chain(pass.stages, pass.width(), scratch);
  const float to_frames = 1 / (pass.limits.front().mean_scale *
                               static_cast<float>(pass.stages.bands.front().sinusoid.steps));
  return code_coordinates(*pass.stages.code, pass.frame_rows(row, scratch), pass.width(),
                          {mean, to_frames}, scratch);
}

/// Turns of all bands to coordinates, along the chain. Where `maps` are wanted of the row they get
/// the coordinates of dark pixels too.
template <class Pixel>
void unwrap_bands(const Pass<Pixel>& pass, int row, const float* mean, FusedScratch& scratch,
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
void several_bands(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
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

/// Frames to coordinates by each pixel alone. A row past the band is another's, and decoded for the
/// vote only.
template <class Pixel>
void decode_with_cue(const Pass<Pixel>& pass, int row, bool ours, FusedScratch& scratch) {
  scratch.block.forget_costs(row);
  CueRow to{.width = pass.width(),
            .coordinate = scratch.block.coordinates(row),
            .mean = ours ? pass.mean_row(row, scratch) : scratch.mean.begin(),
            .flags = scratch.block.flags(row),
            .past_cache = ours && pass.past_cache,
            .modulation = ours ? pass.modulation_row(row) : nullptr};
  if (Maps* const maps = ours ? pass.output.maps : nullptr) {
    to.turn = scratch.turns.begin();
    to.doubt = maps->fringe_order_doubt.row(row);
    to.unhidden_coordinate = maps->coordinate.row(row);
  }
  decode_row(pass.stages.bands.front().sinusoid, pass.stages.cue->stage, pass.limits.front(),
             pass.cue_limits, pass.frame_rows(row, scratch), to);
  if (to.turn != nullptr) pass.finish_maps(row, to.turn);
}

/// What a pixel has instead when the vote has moved it by whole periods.
struct MovedPixel {
  double coordinate = 0;
  double doubt = 0;
  double brighter = 0;  ///< what its mean gains, grey levels of 255
};

void set(const FusedOutput& output, PixelPlace at, const MovedPixel& pixel, double grey_level) {
  if (pixel.brighter != 0 && (output.cloud != nullptr || output.points != nullptr)) {
    Image<float>& intensity =
        output.cloud != nullptr ? output.cloud->intensity : output.points->intensity;
    intensity(at.column, at.row) += static_cast<float>(pixel.brighter);
  }
  if (output.maps == nullptr) return;
  output.maps->coordinate(at.column, at.row) = static_cast<float>(pixel.coordinate);
  output.maps->fringe_order_doubt(at.column, at.row) = static_cast<float>(pixel.doubt);
  output.maps->mean(at.column, at.row) += static_cast<float>(grey_level * pixel.brighter);
}

/// The neighbourhood's vote on the rows from `first` to `last`, and what follows from it for the
/// pixels that it moves.
template <class Pixel>
void vote(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
  VoteBlock& block = scratch.block;
  const FusedStages::Cue& cue = *pass.stages.cue;
  const bool some_dim = pass.cue_limits.lit_square > pass.cue_limits.voting_square;
  VoteField field(cue, pass.frames, pass.full_scale, some_dim,
                  std::get<std::vector<const Pixel*>>(scratch.frames), block);
  block.lists.open.assign(block.disagreeing.begin(), block.disagreeing.end());
  NeighbourhoodVote{field}(block.lists);
  for (const PixelPlace at : block.lists.ever_moved) {
    float& coordinate = block.coordinates(at.row)[at.column];
    std::int32_t& flags = block.flags(at.row)[at.column];
    block.moved.push_back({at, coordinate, flags});
    const double before = coordinate, y = before + block.shift(at) / cue.f_h;
    const CuePixel pixel = field.pixel(at.column, at.row);
    const double doubt = cue.exact.doubt(pixel, y);
    coordinate = static_cast<float>(y);
    flags &= ~PixelFlag::doubtful_order;
    if (doubt > cue.stage.largest_doubt) flags |= PixelFlag::doubtful_order;
    block.shift(at) = 0;
    if (at.row < first || at.row >= last) continue;
    const double brighter = cue.exact.shade(pixel, before) - cue.exact.shade(pixel, y);
    set(pass.output, at, {.coordinate = y, .doubt = doubt, .brighter = brighter},
        pass.full_scale / 255);
  }
}

/// Block by block: what the vote needs to see is decoded, then it is held, then come the points.
template <class Pixel>
void voted_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
  using Block = VoteBlock;
  Block& block = scratch.block;
  const CueStage& cue = pass.stages.cue->stage;
  const auto within = [&](int row) { return std::clamp(row, 0, pass.height()); };
  block.prepare(pass.width());
  int decoded = within(first - Block::seen), asked = within(first - Block::voters);
  block.clear(decoded - Block::looks_past, decoded);
  const auto ask_until = [&](int row) {
    for (; asked < row; ++asked) {
      find_disagreeing(cue,
                       {.width = pass.width(),
                        .row = asked,
                        .above = block.coordinates(asked - 1),
                        .here = block.coordinates(asked),
                        .below = block.coordinates(asked + 1),
                        .far_above = block.far_above.data()},
                       block.disagreeing);
    }
  };
  for (int begin = first, end = first; begin < last; begin = end) {
    end = std::min(begin + Block::most_rows, last);
    block.forget_vote();
    std::erase_if(block.disagreeing,
                  [begin](PixelPlace at) { return at.row < begin - Block::voters; });
    for (; decoded < within(end + Block::seen); ++decoded) {
      decode_with_cue(pass, decoded, decoded >= first && decoded < last, scratch);
      ask_until(std::min(decoded, within(end + Block::voters)));
    }
    block.clear(decoded, decoded + Block::looks_past);
    ask_until(within(end + Block::voters));
    vote(pass, begin, end, scratch);
    if (!pass.output.makes_points()) continue;
    for (int row = begin; row < end; ++row) {
      confirmed_row(
          pass, first, row, block.flags(row), [&](int near) { return block.coordinates(near); },
          scratch);
    }
  }
}

template <class Pixel>
void run_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
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

/// All bands of a scan, on as many threads as there are.
template <class Pixel>
void run_bands(const Pass<Pixel>& pass, std::vector<FusedScratch>& scratch) {
  const int bands = band_count(pass.height(), pass.stages.cue.has_value());
  if (scratch.size() < index(bands)) scratch.resize(index(bands));

  // One captured reference: std::function then allocates nothing.
  struct Work {
    const Pass<Pixel>& pass;
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
      append_packed(work.border(band), scratch[index(band)].packed, *points);
    }
  }
}

}  // namespace

FusedEngine::FusedEngine(FusedStages stages, ReconstructSettings settings)
    : stages_(std::move(stages)), settings_(std::move(settings)) {}

std::optional<FusedEngine> FusedEngine::make(const EngineSetup& setup,
                                             const PhaseCorrections& corrections) {
  std::optional<FusedStages> stages = fused_stages(setup, corrections);
  if (!stages) return std::nullopt;
  return FusedEngine(std::move(*stages), setup.settings);
}

void FusedEngine::operator()(const FrameViews& frames, const FusedOutput& output,
                             FusedMemory& memory, const Image<float>* coarse) const {
  if ((coarse != nullptr) != stages_.coarse_given) {
    throw Error("a coordinate is given where, and only where, the picture gives the fringe order");
  }
  require_frames(frames, stages_);
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
      const Pass<Pixel> pass{
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
