// The fused pass on frames with a cue: the neighbours vote on the fringe orders.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/reconstruct/fused/fused_pass.h"

namespace slipstream {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

/// One scan as NeighbourhoodVote looks at it.
template <class Pixel>
class VoteField {
 public:
  /// `some_dim`: pixels that have no say may have coordinates. `rows`: room for one of each frame.
  VoteField(const FusedStages::Cue& cue, const Frames<Pixel>& frames, double full_scale,
            bool some_dim, std::vector<const Pixel*>& rows, VoteBlock& block)
      : cue_(cue),
        frames_(frames),
        rows_(rows),
        to_8_bits_(255 / full_scale),
        some_dim_(some_dim),
        block_(block) {}

  [[nodiscard]] double periods(int column, int row) const {
    const double y = block_.coordinates(row)[column];
    if (some_dim_ && y == y && (block_.flags(row)[column] & PixelFlag::dim) != 0) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    return y * cue_.f_h;
  }
  void periods_around(int column, int row, PhaseWindow& window) const {
    constexpr int reach = VoteBlock::looks_past;
    const auto f_h = static_cast<float>(cue_.f_h);
    const float own = block_.coordinates(row)[column];  // differences of coordinates are exact
    for (int r = 0; r < 2 * reach + 1; ++r) {
      float* const line = &window.periods[static_cast<std::size_t>(r) * PhaseWindow::line];
      const float* y = block_.coordinates(row + r - reach) + column - reach;
      for (std::size_t c = 0; c < PhaseWindow::line; ++c) line[c] = f_h * (y[c] - own);
      if (!some_dim_) continue;
      for (int c = 0; c < 2 * reach + 1; ++c) {
        if (std::isnan(periods(column + c - reach, row + r - reach))) {
          line[c] = std::numeric_limits<float>::quiet_NaN();
        }
      }
    }
  }
  /// Costs of the pixels that will vote on these, as far as they are not known.
  void foresee(const std::vector<PixelPlace>& open) {
    constexpr int reach = 2, last = costed_together - 1;
    PixelPlace known{-1, 0};  // row, and end of the columns
    for (const PixelPlace at : open) {
      const int first = std::max(at.column - reach, 0) & ~last;
      const int end = std::min((at.column + reach + 1 + last) & ~last, block_.width());
      // Most have the columns of the one before: they come by rows, from left to right.
      if (at.row == known.row && end == known.column && end - first <= costed_together) continue;
      known = {at.row, end};
      for (int row = std::max(at.row - reach, 0);
           row <= std::min(at.row + reach, frames_[0].height() - 1); ++row) {
        for (int column = first; column < end; column += costed_together) {
          if (block_.costs_known(column, row) == 0) find_costs(column, row);
        }
      }
    }
  }
  /// Dim pixels have coordinates and no say, of which the vectors do not know.
  void hold_ballots(std::span<ShiftedPixel> pixels) const {
    if (!some_dim_) slipstream::hold_ballots(ballots(), pixels);
  }
  void find_support(std::span<ShiftedPixel> pixels) const {
    if (!some_dim_) slipstream::find_support(ballots(), pixels);
  }
  struct Window {
    const VoteField& field;
    PixelPlace first;
    std::array<OrderCosts, 5> costs;
    std::array<const std::int16_t*, 5> shifts;

    [[nodiscard]] double against(int cell, int shift) const {
      const OrderCosts& known = costs[static_cast<std::size_t>(cell / 5)];
      if (shift == 1) return known.above[cell % 5];
      if (shift == -1) return known.below[cell % 5];
      return shift == 0 ? 0 : field.against(first.column + cell % 5, first.row + cell / 5, shift);
    }
    [[nodiscard]] int shift(int line, int column) const {
      return shifts[static_cast<std::size_t>(line)][column];
    }
  };
  [[nodiscard]] Window window_around(int column, int row) const {
    Window window{.field = *this, .first = {row - 2, column - 2}, .costs = {}, .shifts = {}};
    for (int r = 0; r < 5; ++r) {
      const OrderCosts costs = block_.costs(row - 2 + r);
      window.costs[static_cast<std::size_t>(r)] = {costs.below + column - 2,
                                                   costs.above + column - 2};
      window.shifts[static_cast<std::size_t>(r)] = block_.shifts(row - 2 + r) + column - 2;
    }
    return window;
  }
  /// Of any shift.
  [[nodiscard]] double against(int column, int row, int shift) const {
    const double own = block_.coordinates(row)[column], y = own + shift / cue_.f_h;
    if (!cue_.exact.near_field(y, cue_.projector_length)) {
      return std::numeric_limits<double>::infinity();
    }
    const CuePixel said = pixel(column, row);
    return cue_.exact.cost(said, y) - cue_.exact.cost(said, own);
  }
  /// On the circle the nearest order is the likeliest.
  [[nodiscard]] bool own_order_costs_least() const { return cue_.exact.is_circle(); }
  [[nodiscard]] int shift(int column, int row) const { return block_.shift({row, column}); }
  void set_shift(int column, int row, int shift) {
    block_.shift({row, column}) = static_cast<std::int16_t>(shift);
  }

  /// Without its wrapped phase.
  [[nodiscard]] CuePixel pixel(int column, int row) const {
    double C = 0, S = 0;
    CuePixel pixel;
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      const double I = to_8_bits_ * frames_[n](column, row);
      C += cue_.costs.cosines[n] * I;
      S += cue_.costs.sines[n] * I;
      pixel.cue += cue_.costs.cue[n] * I;
      pixel.cue_sine += cue_.costs.cue_sine[n] * I;
    }
    pixel.modulation = std::sqrt(C * C + S * S);
    return pixel;
  }

 private:
  [[nodiscard]] BallotRows ballots() const { return block_.ballots(static_cast<float>(cue_.f_h)); }

  /// The last vector of a row overlaps the one before it.
  void find_costs(int column, int row) {
    const int first = std::min(column, block_.width() - costed_together);
    std::transform(frames_.begin(), frames_.end(), rows_.begin(),
                   [&](const auto& frame) { return frame.row(row) + first; });
    order_costs(cue_.costs, static_cast<float>(to_8_bits_), rows_.data(),
                block_.coordinates(row) + first,
                {block_.costs(row).below + first, block_.costs(row).above + first});
    block_.costs_known(column, row) = 1;
  }

  const FusedStages::Cue& cue_;
  const Frames<Pixel>& frames_;
  std::vector<const Pixel*>& rows_;
  double to_8_bits_;
  bool some_dim_;
  VoteBlock& block_;
};

/// Frames to coordinates by each pixel alone. A row past the band is another's, and decoded for the
/// vote only.
template <class Pixel>
void decode_with_cue(const FusedPass<Pixel>& pass, int row, bool ours, FusedScratch& scratch) {
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

void set(const Outputs& output, PixelPlace at, const MovedPixel& pixel, double grey_level) {
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
void vote(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
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

}  // namespace

template <class Pixel>
void voted_band(const FusedPass<Pixel>& pass, int first, int last, FusedScratch& scratch) {
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

template void voted_band(const FusedPass<std::uint8_t>&, int, int, FusedScratch&);
template void voted_band(const FusedPass<std::uint16_t>&, int, int, FusedScratch&);

void VoteBlock::prepare(int width) {
  static_assert(kept_rows >= most_rows + 2 * (seen + looks_past));
  if (flags_.width() != width) {
    coordinate_ = Image<float>({width + 2 * side, kept_rows}, nothing);
    flags_ = Image<std::int32_t>({width, kept_rows});
    shift_ = Image<std::int16_t>({width + 2 * side, kept_rows});
    below_ = Image<float>({width + 2 * side, kept_rows});
    above_ = Image<float>({width + 2 * side, kept_rows});
    costs_known_ = Image<std::uint8_t>({width / costed_together + 1, kept_rows});
  }
  moved.clear();
  disagreeing.clear();
  far_above.assign(static_cast<std::size_t>(width), 1);
}

void VoteBlock::clear(int first, int last) {
  for (int row = first; row < last; ++row) {
    std::fill_n(coordinates(row), flags_.width(), nothing);
  }
}

void VoteBlock::forget_vote() {
  for (const auto& [at, coordinate, pixel_flags] : moved) {
    coordinates(at.row)[at.column] = coordinate;
    flags(at.row)[at.column] = pixel_flags;
  }
  moved.clear();
}

}  // namespace slipstream
