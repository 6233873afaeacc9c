#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/frames/frame_views.h"
#include "slipstream/reconstruct/fused/ballots.h"
#include "slipstream/reconstruct/fused/fused_stages.h"
#include "slipstream/reconstruct/fused/order_costs.h"

namespace slipstream {

/// Rows of coordinates around those that become points next: so many that the neighbourhood's vote
/// on them is the same as in the whole picture. A pixel's shift depends on its like within 9 rows
/// (three passes over windows of 5 x 5, three over 3 x 3), and those on phases 4 rows further.
class VoteBlock {
 public:
  static constexpr int most_rows = 88;  ///< that become points at once
  static constexpr int voters = 10;     ///< rows around them in which pixels choose
  static constexpr int seen = 14;       ///< rows around them of which phases are seen
  static constexpr int looks_past = 4;  ///< rows that a vote looks past the last phase

  /// Room for rows of that width, the same as before or another.
  void prepare(int width);

  /// The row's coordinates, NaN before the first pixel and after the last. Only the last rows that
  /// were written are kept.
  [[nodiscard]] float* coordinates(int row) { return coordinate_.row(place(row)) + side; }
  [[nodiscard]] const float* coordinates(int row) const {
    return coordinate_.row(place(row)) + side;
  }
  [[nodiscard]] int width() const { return flags_.width(); }
  [[nodiscard]] OrderCosts costs(int row) {
    return {below_.row(place(row)) + side, above_.row(place(row)) + side};
  }
  /// Whether those of a pixel, and of its `costed_together`, belong to the row's coordinates.
  [[nodiscard]] std::uint8_t& costs_known(int column, int row) {
    return costs_known_(column / costed_together, place(row));
  }
  /// For coordinates that are new.
  void forget_costs(int row) {
    std::fill_n(costs_known_.row(place(row)), costs_known_.width(), std::uint8_t{0});
  }
  [[nodiscard]] std::int32_t* flags(int row) { return flags_.row(place(row)); }
  [[nodiscard]] const std::int32_t* flags(int row) const { return flags_.row(place(row)); }
  /// Of NeighbourhoodVote; 0 between votes.
  [[nodiscard]] std::int16_t& shift(PixelPlace at) { return shifts(at.row)[at.column]; }
  [[nodiscard]] std::int16_t shift(PixelPlace at) const { return shifts(at.row)[at.column]; }

  /// Of a row; 0 before the first pixel and after the last.
  [[nodiscard]] std::int16_t* shifts(int row) { return shift_.row(place(row)) + side; }
  [[nodiscard]] const std::int16_t* shifts(int row) const { return shift_.row(place(row)) + side; }

  [[nodiscard]] BallotRows ballots(float periods) const {
    return {.coordinate = coordinates(0),
            .shift = shifts(0),
            .below = below_.begin() + side,
            .above = above_.begin() + side,
            .stride = coordinate_.width(),
            .kept_rows = kept_rows,
            .periods = periods};
  }

  /// Makes rows NaN: those outside the picture, or not yet known.
  void clear(int first, int last);

  /// Takes back what a vote has changed, so that the next begins with what each pixel said alone.
  void forget_vote();

  /// What a vote has changed, as it was.
  struct Moved {
    PixelPlace at;
    float coordinate = 0;
    std::int32_t flags = 0;
  };
  std::vector<Moved> moved;
  std::vector<PixelPlace> disagreeing;
  std::vector<std::uint8_t> far_above;  ///< CoordinateRows::far_above of the next row
  NeighbourhoodVoteLists lists;

 private:
  static constexpr int kept_rows =
      128;                         // a power of two, at least most_rows + 2 (seen + looks_past)
  static constexpr int side = 16;  // as looks_past, so that rows start at whole vectors

  static int place(int row) { return row & (kept_rows - 1); }

  Image<float> coordinate_;
  Image<std::int32_t> flags_;
  Image<std::int16_t> shift_;
  Image<float> below_, above_;       ///< OrderCosts
  Image<std::uint8_t> costs_known_;  ///< of `costed_together` pixels
};

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

}  // namespace slipstream
