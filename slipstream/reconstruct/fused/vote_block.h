#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/decode/neighbourhood_vote.h"
#include "slipstream/reconstruct/fused/vote_rows.h"

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

}  // namespace slipstream
