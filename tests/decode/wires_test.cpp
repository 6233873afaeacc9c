#include <cmath>
#include <cstdint>
#include <ostream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "slipstream/codes/phase_channel_multiplexing.h"
#include "slipstream/codes/strategy.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/frames/frame_set.h"

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

class OnWires : public testing::TestWithParam<Coding> {};

TEST_P(OnWires, NeighboursMakeNoMoreOrdersWrongThanEachPixelAloneWould) {
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

// The defaults, and what docs/pcmp.md says of more periods.
INSTANTIATE_TEST_SUITE_P(Codings, OnWires,
                         testing::Values(Coding{3, 3, 0.5}, Coding{4, 6, 0.6}, Coding{5, 12, 0.6},
                                         Coding{5, 25, 0.49}, Coding{5, 25, 0.6}),
                         [](const auto& info) {
                           return fmt::format("N{}with{}Periods{}", info.param.steps,
                                              info.param.high, info.index);
                         });

}  // namespace slipstream::wires_test
