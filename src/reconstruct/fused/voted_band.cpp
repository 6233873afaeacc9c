// The fused pass for frames with a cue: the neighbours vote on the fringe orders.
#include "reconstruct/fused/voted_band.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "decode/cue_evidence.h"
#include "reconstruct/fused/ballots.h"
#include "reconstruct/fused/cue_rows.h"
#include "reconstruct/fused/fused_band.h"
#include "reconstruct/fused/kept_rows.h"
#include "reconstruct/fused/vote_rows.h"

namespace slipstream {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

/// Access to a scan for NeighbourhoodVote.
class VoteField {
 public:
  explicit VoteField(const FusedBand& band)
      : band_(band),
        cue_(*band.stages.cue),
        block_(band.scratch.block),
        to_8_bits_(255 / band.frames.full_scale()),
        some_dim_(band.cue_limits.lit_square > band.cue_limits.voting_square) {}

  [[nodiscard]] double periods(int column, int row) const {
    const double y = block_.coordinates(row)[column];
    const bool no_vote = some_dim_ && y == y && (block_.flags(row)[column] & PixelFlag::dim) != 0;
    return no_vote ? nothing : y * cue_.f_h;
  }

  void periods_around(int column, int row, PhaseWindow& window) const {
    constexpr int reach = VoteBlock::looks_past;
    const auto f_h = static_cast<float>(cue_.f_h);
    const float own = block_.coordinates(row)[column];  // differences of coordinates are exact

    // Whole vectors without a branch; dim pixels are taken out afterwards.
    for (int r = 0; r < 2 * reach + 1; ++r) {
      float* const line = &window.periods[static_cast<std::size_t>(r) * PhaseWindow::line];
      const float* y = block_.coordinates(row + r - reach) + column - reach;

      for (std::size_t c = 0; c < PhaseWindow::line; ++c) line[c] = f_h * (y[c] - own);
      for (int c = 0; some_dim_ && c < 2 * reach + 1; ++c) {
        if (std::isnan(periods(column + c - reach, row + r - reach))) line[c] = nothing;
      }
    }
  }

  /// Computes the missing costs of the pixels that vote on `open`.
  void foresee(const std::vector<PixelPlace>& open) {
    constexpr int reach = 2, last = costed_together - 1;

    PixelPlace known{-1, 0};  // row, and end of the columns
    for (const PixelPlace at : open) {
      // Costs are found in whole groups of columns.
      const int first = std::max(at.column - reach, 0) & ~last;
      const int end = std::min((at.column + reach + 1 + last) & ~last, block_.width());

      // Most have the same columns as the one before, as they come by rows, from left to right.
      if (at.row == known.row && end == known.column && end - first <= costed_together) continue;
      known = {at.row, end};

      for (int row = std::max(at.row - reach, 0);
           row <= std::min(at.row + reach, band_.height() - 1); ++row) {
        for (int column = first; column < end; column += costed_together) {
          if (block_.costs_known(column, row) == 0) find_costs(column, row);
        }
      }
    }
  }

  /// Not if there are dim pixels: vectors cannot tell that these have coordinates but no vote.
  void hold_ballots(std::span<ShiftedPixel> pixels, bool restores) const {
    BallotRows rows = block_.ballots(static_cast<float>(cue_.f_h));
    if (!some_shifts_) rows.shift = nullptr;
    if (!some_dim_) slipstream::hold_ballots(rows, pixels, restores);
  }

  [[nodiscard]] double against(PixelPlace at, int shift) const {
    if (shift == 0) return 0;
    if (std::abs(shift) <= order_shifts.back()) {
      return block_.costs(at.row)[index_of_shift(shift)][at.column];
    }

    // Further shifts are rare, so their costs are not stored.
    const double own = block_.coordinates(at.row)[at.column], y = own + shift / cue_.f_h;
    if (!cue_.exact.near_field(y, cue_.projector_length)) {
      return std::numeric_limits<double>::infinity();
    }

    const CuePixel cue = pixel(at.column, at.row);
    return cue_.exact.cost(cue, y) - cue_.exact.cost(cue, own);
  }

  /// On the circle the nearest order is the most likely.
  [[nodiscard]] bool own_order_costs_least() const { return cue_.exact.is_circle(); }

  [[nodiscard]] int shift(PixelPlace at) const { return block_.shifts(at.row)[at.column]; }

  void set_shift(PixelPlace at, int shift) {
    some_shifts_ = true;
    block_.shifts(at.row)[at.column] = static_cast<std::int16_t>(shift);
  }

  /// All but the wrapped phase.
  [[nodiscard]] CuePixel pixel(int column, int row) const {
    double C = 0, S = 0;
    CuePixel pixel;

    band_.frames.visit([&](const auto& frames) {
      for (std::size_t n = 0; n < frames.size(); ++n) {
        const double I = to_8_bits_ * frames[n](column, row);
        C += cue_.costs.cosines[n] * I;
        S += cue_.costs.sines[n] * I;
        pixel.cue += cue_.costs.cue[n] * I;
        pixel.cue_sine += cue_.costs.cue_sine[n] * I;
      }
    });

    pixel.modulation = std::sqrt(C * C + S * S);
    return pixel;
  }

 private:
  /// The last group of a row overlaps the one before it.
  void find_costs(int column, int row) {
    const int first = std::min(column, block_.width() - costed_together);
    OrderCosts costs = block_.costs(row);
    for (float*& of_shift : costs) of_shift += first;
    order_costs(cue_.costs, static_cast<float>(to_8_bits_), band_.frame_rows(row, first),
                block_.coordinates(row) + first, costs);
    block_.costs_known(column, row) = 1;
  }

  const FusedBand& band_;
  const FusedStages::Cue& cue_;
  VoteBlock& block_;
  double to_8_bits_;
  bool some_dim_;  ///< some pixels with coordinates may not vote
  bool some_shifts_ = false;
};

/// Decodes a row, each pixel by itself. Rows outside the band are decoded only for the vote.
void decode_with_cue(const FusedBand& band, int row) {
  FusedScratch& scratch = band.scratch;
  const bool ours = row >= band.first && row < band.last;

  scratch.block.forget_costs(row);
  CueRow to{.limits = band.limits.front(),
            .cue_limits = band.cue_limits,
            .width = band.width(),
            .coordinate = scratch.block.coordinates(row),
            .mean = ours ? band.mean_row(row) : scratch.mean.begin(),
            .flags = scratch.block.flags(row),
            .past_cache = ours && band.past_cache,
            .modulation = ours ? band.modulation_row(row) : nullptr};

  // Maps also take the doubt and the coordinates of all pixels.
  if (Maps* const maps = ours ? band.output.maps : nullptr) {
    to.turn = scratch.turns.begin();
    to.doubt = maps->fringe_order_doubt.row(row);
    to.unhidden_coordinate = maps->coordinate.row(row);
  }

  decode_row(band.stages.bands.front().sinusoid, band.stages.cue->stage, band.frame_rows(row), to);
  if (to.turn != nullptr) band.finish_maps(row, to.turn);
}

/// Votes on the rows from `first` to `last` and updates the pixels that it moves.
void vote(const FusedBand& band, int first, int last) {
  VoteBlock& block = band.scratch.block;
  const FusedStages::Cue& cue = *band.stages.cue;
  const auto& [cloud, points, maps] =
      std::tie(band.output.cloud, band.output.points, band.output.maps);

  VoteField field(band);
  block.lists.open.assign(block.disagreeing.begin(), block.disagreeing.end());
  NeighbourhoodVote{field}(block.lists);

  // Move the pixels that the vote has moved, and remember them: the next block votes on some again.
  for (const PixelPlace at : block.lists.ever_moved) {
    float& coordinate = block.coordinates(at.row)[at.column];
    std::int32_t& flags = block.flags(at.row)[at.column];
    std::int16_t& shift = block.shifts(at.row)[at.column];
    block.moved.push_back({at, coordinate, flags});

    // Coordinate and doubt at the new order.
    const double before = coordinate, y = before + shift / cue.f_h;
    const CuePixel pixel = field.pixel(at.column, at.row);
    const double doubt = cue.exact.doubt(pixel, y);

    coordinate = static_cast<float>(y);
    flags &= ~PixelFlag::doubtful_order;
    if (doubt > cue.stage.largest_doubt) flags |= PixelFlag::doubtful_order;
    shift = 0;

    // Correct the outputs in this block's own rows. The mean was written without the cue's
    // contribution at the old coordinate.
    if (at.row < first || at.row >= last) continue;
    const double brighter = cue.exact.shade(pixel, before) - cue.exact.shade(pixel, y);
    if (brighter != 0 && (cloud != nullptr || points != nullptr)) {
      Image<float>& intensity = cloud != nullptr ? cloud->intensity : points->intensity;
      intensity(at.column, at.row) += static_cast<float>(brighter);  // grey levels of 255
    }
    if (maps == nullptr) continue;
    maps->coordinate(at.column, at.row) = coordinate;
    maps->fringe_order_doubt(at.column, at.row) = static_cast<float>(doubt);
    maps->mean(at.column, at.row) += static_cast<float>(band.frames.full_scale() / 255 * brighter);
  }
}

}  // namespace

void voted_band(const FusedBand& band) {
  using Block = VoteBlock;
  Block& block = band.scratch.block;
  const auto within = [&](int row) { return std::clamp(row, 0, band.height()); };

  // Rows not yet decoded are NaN, so they confirm no pixel.
  block.prepare(band.width());
  int decoded = within(band.first - Block::seen), compared = within(band.first - Block::voters);
  block.clear(decoded - Block::looks_past, decoded);

  // A row can be compared once the row below it is decoded.
  const auto compare_until = [&](int row) {
    for (; compared < row; ++compared) {
      find_disagreeing(band.stages.cue->stage,
                       {.width = band.width(),
                        .row = compared,
                        .above = block.coordinates(compared - 1),
                        .here = block.coordinates(compared),
                        .below = block.coordinates(compared + 1),
                        .far_above = block.far_above.data()},
                       block.disagreeing);
    }
  };

  for (int begin = band.first, end = begin; begin < band.last; begin = end) {
    end = std::min(begin + Block::most_rows, band.last);

    // 1. Undo the last block's moves; keep only the pixels that can still matter.
    for (const auto& [at, coordinate, flags] : block.moved) {  // votes start from own coordinates
      block.coordinates(at.row)[at.column] = coordinate;
      block.flags(at.row)[at.column] = flags;
    }
    block.moved.clear();

    std::erase_if(block.disagreeing,
                  [begin](PixelPlace at) { return at.row < begin - Block::voters; });

    // 2. Decode the rows that the vote needs, and find the pixels in dispute.
    for (; decoded < within(end + Block::seen); ++decoded) {
      decode_with_cue(band, decoded);
      compare_until(std::min(decoded, within(end + Block::voters)));
    }
    block.clear(decoded, decoded + Block::looks_past);
    compare_until(within(end + Block::voters));

    // 3. Vote, and turn the block's rows into points.
    vote(band, begin, end);
    if (!band.output.makes_points()) continue;
    for (int row = begin; row < end; ++row) band.finish_points(row, block);
  }
}

void VoteBlock::prepare(int width) {
  constexpr int count = 256;
  static_assert(count >= most_rows + 2 * (seen + looks_past));

  if (this->width() != width) {
    KeptRows::prepare(width, count);
    shift_ = Image<std::int16_t>(coordinate_.size());
    for (Image<float>& of_shift : costs_) of_shift = Image<float>(coordinate_.size());
    costs_known_ = Image<std::uint8_t>({width / costed_together + 1, count});
  }

  moved.clear();
  disagreeing.clear();
  far_above.assign(static_cast<std::size_t>(width), 1);
}

BallotRows VoteBlock::ballots(float periods) {
  const OrderCosts of_shifts = costs(0);

  return {.coordinate = coordinates(0),
          .shift = shifts(0),
          .costs = {of_shifts[0], of_shifts[1], of_shifts[2], of_shifts[3]},
          .stride = coordinate_.width(),
          .kept_rows = coordinate_.height(),
          .periods = periods};
}

}  // namespace slipstream
