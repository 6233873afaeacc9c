#include "decode/neighbourhood_vote.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <ostream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "slipstream/frame_set.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/strategy.h"

namespace slipstream::neighbourhood_fringe_order_test {

constexpr Size size{24, 20};

/// A surface of `coordinate` periods; each pixel's cue says so with the same certainty, but for
/// those that are told otherwise.
struct Surface {
  Image<double> periods{size};
  Image<int> said{size};
  Image<std::uint8_t> lit{size, 1};
  double certainty = 3;

  template <class Coordinate>
  explicit Surface(const Coordinate& coordinate) {
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        periods(column, row) = coordinate(column, row);
        said(column, row) = truth(column, row);
      }
    }
  }

  [[nodiscard]] int truth(int column, int row) const {
    return static_cast<int>(std::floor(periods(column, row)));
  }

  [[nodiscard]] int count_wrong() const {
    Image<double> phase(size);
    std::transform(periods.begin(), periods.end(), phase.begin(),
                   [](double p) { return 2 * std::numbers::pi * (p - std::floor(p)); });
    Image<int> orders = said;
    choose_with_neighbours(orders, phase, lit, [&](int column, int row, int order) {
      const double off = order - said(column, row);
      return certainty * off * off;
    });
    int wrong = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        if (orders(column, row) != truth(column, row)) ++wrong;
      }
    }
    return wrong;
  }
};

double slope(int column, int row) {
  return 3.2 + 0.07 * column + 0.03 * row;
}

TEST(NeighbourhoodVote, NeighbourhoodFringeOrderMendsScatteredPixelsAlsoWhereThePhaseWraps) {
  Surface surface(slope);
  EXPECT_EQ(surface.count_wrong(), 0);
  for (int row = 1; row < size.height; row += 3) {
    for (int column = row % 2; column < size.width; column += 3) {
      surface.said(column, row) += column % 2 == 0 ? 1 : -1;
    }
  }
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodVote, NeighbourhoodFringeOrderDoesNotReachAcrossAnEdge) {
  // A tongue one pixel wide before a wall whose cue says another order, everywhere.
  Surface surface(
      [](int column, int row) { return slope(column, row) + (column == 12 && row > 5 ? 2.4 : 0); });
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodVote, NeighbourhoodFringeOrderKeepsWhatStandsAtAnEdgeOfWholePeriods) {
  // The wrapped phase shows nothing of it; the corner has most of its neighbours on the other side.
  Surface surface(
      [](int column, int row) { return slope(column, row) + (column > 8 && row > 8 ? 1 : 0); });
  EXPECT_EQ(surface.count_wrong(), 0);
}

TEST(NeighbourhoodVote, NeighbourhoodFringeOrderAsksNobodyInTheDark) {
  Surface surface(slope);
  surface.said(10, 10) += 1;
  for (const auto& [column, row] : {std::pair{9, 10}, {11, 10}, {10, 9}, {10, 11}}) {
    surface.lit(column, row) = 0;
  }
  EXPECT_EQ(surface.count_wrong(), 1) << "nothing is known of it but what it says itself";
}

TEST(NeighbourhoodVote, NeighbourhoodFringeOrderEvidenceOfItsOwnStandsAgainstTheNeighbours) {
  Surface surface(slope);
  surface.said(10, 10) += 1;
  surface.certainty = 1000;
  EXPECT_EQ(surface.count_wrong(), 1);
}

TEST(NeighbourhoodVoteEvidence, IsTheLikelihoodOfTheCoordinate) {
  const Layout layout = Strategy(PhaseChannelMultiplexing{.steps = 3}).layout();
  const CueEvidence evidence(layout, {.ambient = 7});
  const CueCost& cost = evidence.cost();
  const auto slope_at = [&](double y) {
    return cost.steady + cost.c2 / cost.c1 * cost.reference(y);
  };
  const CuePixel pixel{.modulation = 40, .cue = cost.constant_light + 40 * slope_at(0.45)};

  // Minus twice its logarithm, integrated over the true modulation.
  const auto expected = [&](double y) {
    double sum = 0;
    for (double b = 0; b < 100; b += 0.01) {
      const double off = pixel.modulation - b;
      const double cue = pixel.cue - cost.constant_light - slope_at(y) * b;
      sum += std::exp(-off * off / cost.component_variance / 2 - cue * cue / cost.cue_variance / 2);
    }
    return -2 * std::log(sum);
  };
  for (const double y : {0.4, 0.45, 0.47}) {
    EXPECT_NEAR(evidence.cost(pixel, y) - evidence.cost(pixel, 0.5), expected(y) - expected(0.5),
                1e-6)
        << "y " << y;
  }

  EXPECT_FALSE(evidence.lit({.modulation = 0.99 * evidence.dimmest_lit()}));
  EXPECT_TRUE(evidence.lit({.modulation = 1.01 * evidence.dimmest_lit()}));
}

TEST(NeighbourhoodVoteEvidence, OfACircleHasNoEnd) {
  const CueEvidence evidence(Strategy(PhaseChannelMultiplexing{.steps = 5}).layout(), {});
  ASSERT_TRUE(evidence.is_circle());
  EXPECT_NEAR(evidence.doubt({.modulation = 50, .cue = 20}, 1), 0, 1e-9);
}

}  // namespace slipstream::neighbourhood_fringe_order_test

// Wires before a slanted plane, without blur: thin things that the neighbours must not vote away.

namespace slipstream::wires_test {

constexpr Size size{240, 200};

struct Wires {
  Image<double> coordinate{size};
  Image<std::uint8_t> on_wire{size};
};

/// Upright wires, and level ones between them, `depth()` periods before the plane.
template <class Depth>
Wires wires(Axis axis, int width, double frequency, const Depth& depth) {
  Wires scene;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double along =
          axis == Axis::x ? (column + 0.5) / size.width : (row + 0.5) / size.height;
      scene.coordinate(column, row) = 0.05 + 0.55 * along;
    }
  }
  const auto add = [&](int column, int row, double periods) {
    if (scene.on_wire(column, row) != 0) return;
    scene.on_wire(column, row) = 1;
    scene.coordinate(column, row) += periods / frequency;
  };
  for (int first = 20; first + width < size.width; first += 44) {
    const double periods = depth();
    for (int column = first; column < first + width; ++column) {
      for (int row = 0; row < size.height; ++row) add(column, row, periods);
    }
  }
  for (int first = 30; first + width < size.height; first += 50) {
    const double periods = depth();
    for (int row = first; row < first + width; ++row) {
      for (int column = 0; column < size.width; ++column) add(column, row, periods);
    }
  }
  return scene;
}

/// With the noise of the simulations of Section 3.2.
FrameSet frames_of(const PatternSet& patterns, const Image<double>& y, double reflectivity) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, std::sqrt(1.55));
  FrameSet::ImagesUnquantised frames;
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& frame = frames.emplace_back(y.size());
    for (std::size_t i = 0; i < y.pixel_count(); ++i) {
      frame.begin()[i] =
          reflectivity * (patterns.intensity(n, y.begin()[i]) + 5) + 5 + noise(random);
    }
  }
  return FrameSet(std::move(frames));
}

struct Coding {
  int steps;
  double high, share;

  friend std::ostream& operator<<(std::ostream& out, const Coding& of) {
    return out << fmt::format("N = {}, f_h = {}, c_1 = {}", of.steps, of.high, of.share);
  }
};

/// % of the pixels on wires that are a fringe or more off, of both axes.
double wrong_on_wires(const Coding& coding, CueRule rule, double reflectivity, int width,
                      bool random_depth) {
  const Strategy strategy = PhaseChannelMultiplexing{
      .steps = coding.steps, .high = coding.high, .share = coding.share, .reference = {}};
  const CueSettings cue{
      .light = {.alpha_p = 200, .beta_p = 55}, .ambient = 5, .noise_variance = 1.55, .rule = rule};
  int wrong = 0, all = 0;
  for (const Axis axis : {Axis::x, Axis::y}) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(0.1, 0.35 * coding.high);
    const Wires scene =
        wires(axis, width, coding.high, [&] { return random_depth ? any(random) : 1.0; });
    const FrameSet frames =
        frames_of(pattern_set(strategy, axis, cue.light), scene.coordinate, reflectivity);
    const BasicMaps<double> maps =
        Decoder(strategy.layout(), 1140, PhaseMethod::equation, {}, cue)(frames);
    for (std::size_t i = 0; i < scene.coordinate.pixel_count(); ++i) {
      if (scene.on_wire.begin()[i] == 0) continue;
      ++all;
      const double error = maps.coordinate.begin()[i] - scene.coordinate.begin()[i];
      if (std::abs(error) > 0.5 / coding.high) ++wrong;
    }
  }
  return 100.0 * wrong / all;
}

class NeighbourhoodVoteOnWires : public testing::TestWithParam<Coding> {};

TEST_P(NeighbourhoodVoteOnWires, NeighboursMakeNoMoreOrdersWrongThanEachPixelAloneWould) {
  for (const double reflectivity : {0.3, 0.5}) {
    for (const int width : {1, 2, 3}) {
      for (const bool random_depth : {false, true}) {
        const auto wrong = [&](CueRule rule) {
          return wrong_on_wires(GetParam(), rule, reflectivity, width, random_depth);
        };
        EXPECT_LE(wrong(CueRule::consensus), wrong(CueRule::likelihood) + 0.2)
            << fmt::format("reflectivity {}, {} px, {}", reflectivity, width,
                           random_depth ? "any depth" : "one period before the plane");
      }
    }
  }
}

// The defaults, and what docs/background/pcmp.md says of more periods.
INSTANTIATE_TEST_SUITE_P(Codings, NeighbourhoodVoteOnWires,
                         testing::Values(Coding{3, 3, 0.5}, Coding{4, 6, 0.6}, Coding{5, 12, 0.6},
                                         Coding{5, 25, 0.49}, Coding{5, 25, 0.6}),
                         [](const auto& info) {
                           return fmt::format("N{}with{}Periods{}", info.param.steps,
                                              info.param.high, info.index);
                         });

}  // namespace slipstream::wires_test
