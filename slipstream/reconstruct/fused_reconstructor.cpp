#include "slipstream/reconstruct/fused_reconstructor.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr int padding = least_row_width;
constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

template <class Pixel>
void prepare(Image<Pixel>& image, Size size) {
  if (image.size() != size) image = Image<Pixel>(size);
}

/// Before the first and after the last pixel stands NaN, which confirms no neighbour.
void prepare(FusedScratch::Row& row, int width) {
  prepare(row.coordinate, {width + 2 * padding, 1});
  std::fill(row.coordinate.begin(), row.coordinate.end(), std::numeric_limits<float>::quiet_NaN());
  prepare(row.flags, {width, 1});
}

void prepare(FusedScratch& scratch, int width, int frames) {
  if (scratch.turn.width() != width) {
    for (FusedScratch::Row& row : scratch.rows) prepare(row, width);
    for (Image<float>* row : {&scratch.turn, &scratch.low_turn, &scratch.mean}) {
      prepare(*row, {width, 1});
    }
  }
  std::apply([&](auto&... rows) { (rows.resize(index(frames)), ...); }, scratch.frames);
}

void prepare(FusedCloud& cloud, Size size, bool) {
  for (Image<float>* image : {&cloud.x, &cloud.y, &cloud.z, &cloud.intensity}) {
    prepare(*image, size);
  }
  prepare(cloud.validity, size);
}

void prepare(FusedDepth& depth, Size size, bool) {
  prepare(depth.z, size);
  prepare(depth.validity, size);
}

void prepare(FusedDecoding& decoding, Size size, bool doubtful) {
  for (Image<float>* image :
       {&decoding.mean, &decoding.modulation, &decoding.wrapped_phase, &decoding.coordinate}) {
    prepare(*image, size);
  }
  prepare(decoding.fringe_order_doubt, doubtful ? size : Size{});
}

/// One scan on its way through the stages.
template <class Pixel>
struct Pass {
  const FusedStages& stages;
  const Frames<Pixel>& frames;
  double full_scale;
  SinusoidLimits limits;
  SinusoidLimits low_limits;
  CueLimits cue_limits;

  [[nodiscard]] int width() const { return frames.front().width(); }
  [[nodiscard]] int height() const { return frames.front().height(); }

  const Pixel* const* frame_rows(int row, FusedScratch& scratch) const {
    auto& rows = std::get<std::vector<const Pixel*>>(scratch.frames);
    std::transform(frames.begin(), frames.end(), rows.begin(),
                   [row](const auto& frame) { return frame.row(row); });
    return rows.data();
  }

  /// Frames of one row to turns and flags; the turns of the low frequency into `low_turn`.
  void decode(int row, FusedScratch& scratch, const SinusoidRow& kept) const {
    const Pixel* const* rows = frame_rows(row, scratch);
    decode_row(stages.sinusoid, limits, rows, kept);
    if (!stages.low) return;
    SinusoidRow low = kept;
    low.turn = scratch.low_turn.begin();
    low.another = true;
    decode_row(stages.low->sinusoid, low_limits, rows + stages.sinusoid.steps, low);
  }
};

float* coordinates(FusedScratch::Row& row) {
  return row.coordinate.begin() + padding;
}

/// Where what is written would push out of the cache what is read, and rows start at whole vectors
/// or at halves of the widest.
bool written_past_cache(Size size) {
  constexpr int cached_pixels = 2'000'000;
  return size.width % (least_row_width / 2) == 0 &&
         std::int64_t{size.width} * size.height > cached_pixels;
}

template <class Output>
constexpr bool keeps_intensity = std::is_same_v<Output, FusedCloud>;

template <class Output>
float* intensity_row(Output& output, int row, FusedScratch& scratch) {
  if constexpr (keeps_intensity<Output>) return output.intensity.row(row);
  return scratch.mean.begin();
}

template <class Output>
PointRow point_output(const FusedStages& stages, Output& output, int row) {
  PointRow points{
      .width = output.z.width(), .E_x = stages.rays.E_x.row(row), .E_y = stages.rays.E_y.row(row)};
  if (stages.blocks) points.blocks = stages.blocks->at(row);
  if constexpr (std::is_same_v<Output, FusedCloud>) {
    points.x = output.x.row(row);
    points.y = output.y.row(row);
  }
  points.z = output.z.row(row);
  points.past_cache = written_past_cache(output.z.size());
  points.validity = output.validity.row(row);
  return points;
}

template <class Pixel, class Output>
void one_frequency(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch,
                   Output& output) {
  float* turn = scratch.turn.begin();
  std::int32_t* flags = scratch.rows[0].flags.begin();
  for (int row = first; row < last; ++row) {
    pass.decode(row, scratch,
                {.width = pass.width(),
                 .turn = turn,
                 .mean = intensity_row(output, row, scratch),
                 .flags = flags,
                 .past_cache = keeps_intensity<Output> && written_past_cache(output.z.size()),
                 .only_lit = true,
                 .nan_if_flagged = true});
    PointRow points = point_output(pass.stages, output, row);
    points.flags = flags;
    points.coordinate = turn;
    point_row(pass.stages.point, pass.stages.coordinate, points);
  }
}

/// Points of a row whose neighbours confirm it; `coordinates(row)` are padded on both sides.
template <class Output, class Coordinates>
void confirmed_row(const FusedStages& stages, const ConsensusStage& consensus, int row,
                   const std::int32_t* flags, const Coordinates& coordinates, Output& output) {
  PointRow points = point_output(stages, output, row);
  points.flags = flags;
  points.above = coordinates(row - 1);
  points.coordinate = coordinates(row);
  points.below = coordinates(row + 1);
  point_row(stages.point, consensus, points);
}

/// The coordinates of each row are kept until those below it are known, for its neighbours confirm
/// them.
template <class Pixel, class Output>
void two_frequencies(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch,
                     Output& output) {
  const auto kept = [&](int row) -> FusedScratch::Row& { return scratch.rows[index(row + 3) % 3]; };
  const auto decode = [&](int row) {
    if (row < 0 || row >= pass.height()) return prepare(kept(row), pass.width());
    const bool ours = row >= first && row < last;
    std::int32_t* flags = kept(row).flags.begin();
    pass.decode(
        row, scratch,
        {.width = pass.width(),
         .turn = scratch.turn.begin(),
         .mean = ours ? intensity_row(output, row, scratch) : scratch.mean.begin(),
         .flags = flags,
         .past_cache = ours && keeps_intensity<Output> && written_past_cache(output.z.size()),
         .only_lit = true});
    unwrap_row(pass.stages.low->unwrap, pass.width(), scratch.turn.begin(),
               scratch.low_turn.begin(), PixelFlag::dark,
               {.coordinate = coordinates(kept(row)), .flags = flags});
  };
  decode(first - 1);
  decode(first);
  for (int row = first; row < last; ++row) {
    decode(row + 1);
    confirmed_row(
        pass.stages, pass.stages.low->consensus, row, kept(row).flags.begin(),
        [&](int near) { return coordinates(kept(near)); }, output);
  }
}

/// Where the row of a multiplexed scan goes beside the picture.
template <class Output>
MultiplexedRow multiplexed_output(Output& output, int row, FusedScratch& scratch) {
  return {.mean = intensity_row(output, row, scratch),
          .past_cache = keeps_intensity<Output> && written_past_cache(output.z.size())};
}

MultiplexedRow multiplexed_output(FusedDecoding& output, int row, FusedScratch& scratch) {
  return {.mean = output.mean.row(row),
          .turn = scratch.turn.begin(),
          .modulation = output.modulation.row(row),
          .doubt = output.fringe_order_doubt.row(row),
          .unhidden_coordinate = output.coordinate.row(row)};
}

/// Frames to coordinates by each pixel alone. A row past the band is another's, and decoded for the
/// vote only.
template <class Pixel, class Output>
void decode_multiplexed(const Pass<Pixel>& pass, int row, bool ours, FusedScratch& scratch,
                        Output& output) {
  MultiplexedRow to{.mean = scratch.mean.begin()};
  if (ours) to = multiplexed_output(output, row, scratch);
  to.width = pass.width();
  to.coordinate = scratch.block.coordinates(row);
  to.flags = scratch.block.flags(row);
  decode_row(pass.stages.sinusoid, pass.stages.cue->stage, pass.limits, pass.cue_limits,
             pass.frame_rows(row, scratch), to);
  if constexpr (std::is_same_v<Output, FusedDecoding>) {
    if (ours) phase_row(to.width, to.turn, output.wrapped_phase.row(row));
  }
}

/// What a pixel has instead when the vote has moved it by whole periods.
struct MovedPixel {
  double coordinate = 0;
  double doubt = 0;
  double brighter = 0;  ///< what its mean gains, grey levels of 255
};

void set(FusedCloud& cloud, PixelPlace at, const MovedPixel& pixel, double) {
  cloud.intensity(at.column, at.row) += static_cast<float>(pixel.brighter);
}

void set(FusedDepth&, PixelPlace, const MovedPixel&, double) {}

void set(FusedDecoding& decoding, PixelPlace at, const MovedPixel& pixel, double grey_level) {
  decoding.coordinate(at.column, at.row) = static_cast<float>(pixel.coordinate);
  decoding.fringe_order_doubt(at.column, at.row) = static_cast<float>(pixel.doubt);
  decoding.mean(at.column, at.row) += static_cast<float>(grey_level * pixel.brighter);
}

/// The neighbourhood's vote on the rows from `first` to `last`, and what follows from it for the
/// pixels that it moves.
template <class Pixel, class Output>
void vote(const Pass<Pixel>& pass, int first, int last, MultiplexedBlock& block, Output& output) {
  const FusedStages::Cue& cue = *pass.stages.cue;
  const bool some_dim = pass.cue_limits.lit_square > pass.cue_limits.voting_square;
  MultiplexedField field(cue, pass.frames, pass.full_scale, some_dim, block);
  block.lists.open.assign(block.disagreeing.begin(), block.disagreeing.end());
  NeighbourhoodVote(field, {})(block.lists);
  for (const PixelPlace at : block.lists.ever_moved) {
    float& coordinate = block.coordinates(at.row)[at.column];
    std::int32_t& flags = block.flags(at.row)[at.column];
    block.moved.push_back({at, coordinate, flags});
    const double before = coordinate, y = before + block.shift(at) / cue.f_h;
    const MultiplexedPixel pixel = field.pixel(at.column, at.row);
    const double doubt = cue.exact.doubt(pixel, y);
    coordinate = static_cast<float>(y);
    flags &= ~PixelFlag::doubtful_order;
    if (doubt > cue.stage.largest_doubt) flags |= PixelFlag::doubtful_order;
    block.shift(at) = 0;
    if (at.row < first || at.row >= last) continue;
    const double brighter = cue.exact.shade(pixel, before) - cue.exact.shade(pixel, y);
    set(output, at, {.coordinate = y, .doubt = doubt, .brighter = brighter}, pass.full_scale / 255);
  }
}

/// Block by block: what the vote needs to see is decoded, then it is held, then come the points.
template <class Pixel, class Output>
void multiplexed_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch,
                      Output& output) {
  using Block = MultiplexedBlock;
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
                        .below = block.coordinates(asked + 1)},
                       block.disagreeing);
    }
  };
  for (int begin = first, end = first; begin < last; begin = end) {
    end = std::min(begin + Block::most_rows, last);
    block.forget_vote();
    std::erase_if(block.disagreeing,
                  [begin](PixelPlace at) { return at.row < begin - Block::voters; });
    for (; decoded < within(end + Block::seen); ++decoded) {
      decode_multiplexed(pass, decoded, decoded >= first && decoded < last, scratch, output);
      ask_until(std::min(decoded, within(end + Block::voters)));
    }
    block.clear(decoded, decoded + Block::looks_past);
    ask_until(within(end + Block::voters));
    vote(pass, begin, end, block, output);
    if constexpr (!std::is_same_v<Output, FusedDecoding>) {
      for (int row = begin; row < end; ++row) {
        confirmed_row(
            pass.stages, pass.stages.cue->consensus, row, block.flags(row),
            [&](int near) { return block.coordinates(near); }, output);
      }
    }
  }
}

template <class Pixel, class Output>
void run_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch, Output& output) {
  if (pass.stages.cue) return multiplexed_band(pass, first, last, scratch, output);
  if (pass.stages.low) return two_frequencies(pass, first, last, scratch, output);
  one_frequency(pass, first, last, scratch, output);
}

template <class Pixel>
void run_band(const Pass<Pixel>& pass, int first, int last, FusedScratch& scratch,
              FusedDecoding& output) {
  if (pass.stages.cue) return multiplexed_band(pass, first, last, scratch, output);
  const int width = pass.width();
  const float* turn = scratch.turn.begin();
  std::int32_t* flags = scratch.rows[0].flags.begin();
  for (int row = first; row < last; ++row) {
    pass.decode(row, scratch,
                {.width = width,
                 .turn = scratch.turn.begin(),
                 .mean = output.mean.row(row),
                 .modulation = output.modulation.row(row),
                 .flags = flags});
    phase_row(width, turn, output.wrapped_phase.row(row));
    if (pass.stages.low) {
      unwrap_row(pass.stages.low->unwrap, width, turn, scratch.low_turn.begin(), 0,
                 {.coordinate = output.coordinate.row(row),
                  .flags = flags,
                  .doubt = output.fringe_order_doubt.row(row)});
    } else {
      place_row(pass.stages.coordinate, width, turn, output.coordinate.row(row));
    }
  }
}

/// Bands so high that the rows decoded twice at their borders do not matter, and several for each
/// thread so that none waits long.
int band_count(int height, bool multiplexed) {
  constexpr int bands_per_thread = 4;
  const int fewest_rows = multiplexed ? 4 * 2 * MultiplexedBlock::seen : 32;
  const int threads = parallel_threads();
  return threads == 1 ? 1 : std::clamp(height / fewest_rows, 1, bands_per_thread * threads);
}

template <class Pixel>
void require_frames(const Frames<Pixel>& frames, int count, Size camera) {
  if (static_cast<int>(frames.size()) != count) {
    throw Error(fmt::format("{} frames given; the strategy takes {}", frames.size(), count));
  }
  for (const auto& frame : frames) {
    if (frame.size() != camera) {
      throw Error(fmt::format("frames are {}x{}, the scanner's camera has {}x{}; both must agree",
                              frame.width(), frame.height(), camera.width, camera.height));
    }
  }
}

}  // namespace

FusedReconstructor::FusedReconstructor(FusedStages stages, ReconstructSettings settings)
    : stages_(std::move(stages)), settings_(std::move(settings)) {}

std::optional<FusedReconstructor> FusedReconstructor::make(const Scanner& scanner,
                                                           const Strategy& strategy, Axis axis,
                                                           const ReconstructSettings& settings) {
  require_reconstructible(scanner, strategy, axis, settings);
  std::optional<FusedStages> stages = fused_stages(scanner, strategy, axis, settings);
  if (!stages) return std::nullopt;
  return FusedReconstructor(std::move(*stages), settings);
}

template <class Pixel, class Output>
void FusedReconstructor::run(const Frames<Pixel>& frames, double full_scale, Output& output) const {
  const Size size = stages_.rays.E_x.size();
  require_frames(frames, stages_.frame_count(), size);
  constexpr bool decoding = std::is_same_v<Output, FusedDecoding>;
  const double mean_of = decoding ? 1 : 255 / full_scale;
  Pass<Pixel> pass{.stages = stages_,
                   .frames = frames,
                   .full_scale = full_scale,
                   .limits = sinusoid_limits(stages_.sinusoid, settings_, full_scale, mean_of),
                   .low_limits = {},
                   .cue_limits = {}};
  if (stages_.low) {
    pass.low_limits = sinusoid_limits(stages_.low->sinusoid, settings_, full_scale, mean_of);
  }
  if (stages_.cue) pass.cue_limits = cue_limits(stages_, settings_, full_scale);
  prepare(output, size, stages_.low || stages_.cue);
  const int bands = band_count(size.height, stages_.cue.has_value());
  if (output.scratch.size() < index(bands)) output.scratch.resize(index(bands));

  // One captured reference: std::function then allocates nothing.
  struct Work {
    const Pass<Pixel>& pass;
    Output& output;
    int bands;
    void operator()(int band) const {
      FusedScratch& scratch = output.scratch[index(band)];
      prepare(scratch, pass.width(), static_cast<int>(pass.frames.size()));
      const auto border = [&](int i) {
        return static_cast<int>(std::int64_t{pass.height()} * i / bands);
      };
      run_band(pass, border(band), border(band + 1), scratch, output);
      flush_past_cache();
    }
  };
  const Work work{pass, output, bands};
  if (bands == 1) return work(0);
  for_each_row(bands, [&work](int band) { work(band); });
}

void FusedReconstructor::operator()(const Frames<std::uint8_t>& frames, FusedCloud& cloud) const {
  run(frames, 255, cloud);
}

void FusedReconstructor::operator()(const Frames<std::uint16_t>& frames, double full_scale,
                                    FusedCloud& cloud) const {
  run(frames, full_scale, cloud);
}

namespace {

/// Calls `run` with the frames of a set as they are.
template <class Run>
void with_pixels(const FrameSet& frames, const Run& run) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      run(views);
    } else {
      throw Error("frames are not quantised; the fused pass takes 8 to 16 bits");
    }
  });
}

}  // namespace

void FusedReconstructor::operator()(const FrameSet& frames, FusedCloud& cloud) const {
  with_pixels(frames, [&](const auto& views) { run(views, frames.full_scale(), cloud); });
}

void FusedReconstructor::operator()(const FrameSet& frames, FusedDepth& depth) const {
  with_pixels(frames, [&](const auto& views) { run(views, frames.full_scale(), depth); });
}

void FusedReconstructor::operator()(const FrameSet& frames, FusedDecoding& decoding) const {
  with_pixels(frames, [&](const auto& views) { run(views, frames.full_scale(), decoding); });
}

}  // namespace slipstream
