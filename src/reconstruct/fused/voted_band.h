#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "decode/neighbourhood_vote.h"
#include "reconstruct/fused/ballots.h"
#include "reconstruct/fused/kept_rows.h"
#include "reconstruct/fused/vote_rows.h"

namespace slipstream {

struct FusedBand;

/// Coordinates of the next rows to become points and of enough rows around them that the
/// neighbours' vote is the same as in the whole image. The shift of a pixel depends on the shifts
/// within 9 rows (three passes over windows of 5 x 5, three over 3 x 3), and those depend on phases
/// 4 rows further.
class VoteBlock : public KeptRows {
 public:
  static constexpr int most_rows = 216;  ///< rows that become points at once
  static constexpr int voters = 10;      ///< rows around them in which pixels get shifts
  static constexpr int seen = 14;        ///< rows around them that are decoded
  static constexpr int looks_past = 4;   ///< rows that a vote reads past the last decoded one

  /// Allocates rows of `width` pixels, unless they are there already.
  void prepare(int width);

  [[nodiscard]] OrderCosts costs(int row) {
    OrderCosts rows;
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = costs_[k].row(place(row)) + side;
    return rows;
  }
  /// Whether the costs of a pixel, and of the others of its `costed_together`, are up to date.
  [[nodiscard]] std::uint8_t& costs_known(int column, int row) {
    return costs_known_(column / costed_together, place(row));
  }
  /// Call after a row gets new coordinates.
  void forget_costs(int row) {
    std::fill_n(costs_known_.row(place(row)), costs_known_.width(), std::uint8_t{0});
  }
  /// Shifts of NeighbourhoodVote; 0 between votes and in the padding.
  [[nodiscard]] std::int16_t* shifts(int row) { return shift_.row(place(row)) + side; }
  [[nodiscard]] BallotRows ballots(float periods);

  /// A pixel changed by a vote, with its values before.
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
  Image<std::int16_t> shift_;
  std::array<Image<float>, order_shifts.size()> costs_;
  Image<std::uint8_t> costs_known_;  ///< one per `costed_together` pixels
};

/// Frames with a cue, block by block: decodes the rows that the vote needs, votes, computes points.
void voted_band(const FusedBand& band);

}  // namespace slipstream
