// The vote's vectors against its rules, on random phases, shifts and costs.
#include "reconstruct/fused/ballots.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bench/vector_target.h"
#include "reconstruct/fused/vote_rows.h"
#include "slipstream/image.h"

namespace slipstream::ballots_test {

constexpr int width = 90, height = 64, side = 16;
constexpr double f_h = 8;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// A picture in as many rows as VoteBlock would keep, with its margins.
struct Picture {
  static constexpr Size size{width + 2 * side, 128};
  Image<float> coordinate{size, nan};
  std::array<Image<float>, order_shifts.size()> costs{Image<float>(size), Image<float>(size),
                                                      Image<float>(size), Image<float>(size)};
  Image<std::int16_t> shift{size};

  static PixelPlace in_image(int column, int row) { return {row & 127, column + side}; }
};

/// Orders said with random mistakes, on a surface with cliffs, holes and rough places. `certainty`:
/// of the costs, large enough for lines to speak.
Picture random_picture(unsigned seed, double certainty) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0, 1);
  const double slope_x = 0.2 * part(random), slope_y = 0.3 * (part(random) - 0.5);
  const double noise = part(random) < 0.5 ? 0.002 : 0.03;
  Picture picture;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto [r, c] = Picture::in_image(column, row);
      double periods = 1 + slope_x * column + slope_y * row + noise * part(random);
      if (column > 50 + row / 5) periods += 2.37;
      if (row > 40 && column < 30) periods -= 1;
      const double luck = part(random);
      if (luck < 0.06) periods += luck < 0.03 ? 1 : -1;
      if (luck > 0.998) periods += 2;
      if (column % 17 == 3 && row > 20) periods += 0.4;
      picture.coordinate(c, r) = part(random) < 0.02 ? nan : static_cast<float>(periods / f_h);
      const double towards = certainty * (part(random) - 0.15);
      auto& [two_below, below, above, two_above] = picture.costs;
      below(c, r) = static_cast<float>(certainty * part(random));
      above(c, r) = static_cast<float>(towards);
      if (part(random) < 0.02) above(c, r) = std::numeric_limits<float>::infinity();
      // Alike neighbours: totals that are equal, but for rounding.
      if (row % 16 < 4) below(c, r) = above(c, r) = 1;
      two_below(c, r) = two_above(c, r) = 6 + below(c, r);
    }
  }
  return picture;
}

/// `quick`: whether NeighbourhoodVote may use the vectors.
template <bool quick>
struct Field {
  Picture picture;

  [[nodiscard]] double periods(int column, int row) const {
    const auto [r, c] = Picture::in_image(column, row);
    return picture.coordinate(c, r) * f_h;
  }
  void periods_around(int column, int row, PhaseWindow& window) const {
    const auto [r, c] = Picture::in_image(column, row);
    for (int dy = 0; dy < 9; ++dy) {
      for (int dx = 0; dx < 9; ++dx) {
        window.periods[static_cast<std::size_t>(dy) * PhaseWindow::line +
                       static_cast<std::size_t>(dx)] =
            static_cast<float>(f_h) *
            (picture.coordinate(c + dx - 4, (r + dy - 4) & 127) - picture.coordinate(c, r));
      }
    }
  }
  static void foresee(const std::vector<PixelPlace>&) {}
  [[nodiscard]] double against(PixelPlace at, int shift) const {
    const auto [r, c] = Picture::in_image(at.column, at.row);
    if (shift == 0) return 0;
    if (std::abs(shift) <= 2) return picture.costs[index_of_shift(shift)](c, r);
    return 3 * std::abs(shift) + picture.costs[index_of_shift(-1)](c, r);
  }
  [[nodiscard]] static bool own_order_costs_least() { return false; }
  [[nodiscard]] int shift(PixelPlace at) const {
    const auto [r, c] = Picture::in_image(at.column, at.row);
    return picture.shift(c, r);
  }
  void set_shift(PixelPlace at, int shift) {
    const auto [r, c] = Picture::in_image(at.column, at.row);
    picture.shift(c, r) = static_cast<std::int16_t>(shift);
  }

  [[nodiscard]] BallotRows rows() const {
    BallotRows rows{.coordinate = picture.coordinate.row(0) + side,
                    .shift = picture.shift.row(0) + side,
                    .stride = Picture::size.width,
                    .kept_rows = Picture::size.height,
                    .periods = static_cast<float>(f_h)};
    for (std::size_t k = 0; k < rows.costs.size(); ++k)
      rows.costs[k] = picture.costs[k].row(0) + side;
    return rows;
  }
  void hold_ballots(std::span<ShiftedPixel> pixels, bool restores) {
    if (quick) slipstream::hold_ballots(rows(), pixels, restores);
    if (restores) return;
    asked += pixels.size();
    left += static_cast<std::size_t>(
        std::count_if(pixels.begin(), pixels.end(),
                      [](const ShiftedPixel& pixel) { return pixel.shift == undecided; }));
  }
  std::atomic<std::size_t> asked = 0, left = 0;
};

template <bool quick>
std::vector<PixelPlace> hold_vote(Field<quick>& field) {
  NeighbourhoodVoteLists lists;
  NeighbourhoodVote vote(field);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      if (vote.disagrees({row, column})) lists.open.push_back({row, column});
    }
  }
  vote(lists);
  return lists.ever_moved;
}

class BallotsOn : public testing::TestWithParam<std::string> {};

TEST_P(BallotsOn, ChooseWhatTheRulesDo) {
  const OnlyVectorTarget only(GetParam());
  std::size_t moved = 0, asked = 0, left = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    for (const double certainty : {0.3, 1.0, 6.0, 30.0}) {
      const Picture picture = random_picture(seed, certainty);
      Field<true> quick{picture};
      Field<false> slow{picture};
      const auto by_vectors = hold_vote(quick), by_rules = hold_vote(slow);
      ASSERT_EQ(by_vectors, by_rules) << "seed " << seed << ", certainty " << certainty;
      ASSERT_TRUE(std::equal(quick.picture.shift.begin(), quick.picture.shift.end(),
                             slow.picture.shift.begin()))
          << "seed " << seed << ", certainty " << certainty;
      EXPECT_EQ(quick.asked.load(), slow.asked.load()) << "passes on the way";
      moved += by_rules.size();
      asked += quick.asked;
      left += quick.left;
    }
  }
  EXPECT_GT(moved, 5000U);
  EXPECT_LT(left, 4 * asked / 5) << "of " << asked;
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, BallotsOn, testing::ValuesIn(vector_targets()),
                         [](const auto& target) { return target.param; });

}  // namespace slipstream::ballots_test
