#include "paper/hand_figures.h"

#include <array>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "decode/equations.h"
#include "paper/cloud_views.h"
#include "simulate/hand.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

/// Moments of the hand's motion, frames: bent, half way and stretched.
constexpr std::array<double, 3> moments{-hand_period / 4, 0, hand_period / 4};

/// A scan of the moving hand, and its cloud.
struct HandScan {
  VirtualScan scan;
  Cloud cloud;
};

HandScan hand_scan(const Sequence& sequence, double moment, std::uint64_t seed) {
  const Scanner scanner = example_scanner({320, 240});
  const Photometry light{.ambient = 5, .noise_variance = 1.55, .seed = seed};
  HandScan taken{.scan = take_scan(scanner, scene_named("hand", scanner), pattern_set(sequence),
                                   light, moment),
                 .cloud = Cloud{}};
  Engine(scanner, sequence).cloud(taken.scan.frames, taken.cloud);
  return taken;
}

/// Adds the number of points at a moment and their error.
void add_cells(const HandScan& taken, double moment, Reproduction& result) {
  const auto points = static_cast<double>(point_count(taken.cloud));
  result.add("points", {{"frame", moment}}, {}, points);
  result.add("median depth error, mm", {{"frame", moment}}, {},
             median_depth_error(taken.cloud, taken.scan.depth));
}

Reproduction figure_23(std::uint64_t seed) {
  const Sequence sequence{.strategy = DualFrequency{.steps = 6}};
  Reproduction result;
  std::vector<Image<std::uint8_t>> photographs, views;
  for (const double moment : moments) {
    const HandScan taken = hand_scan(sequence, moment, seed);
    add_cells(taken, moment, result);
    photographs.push_back(as_picture(weighted_sum(taken.scan.frames, mean_weights(12))));
    views.push_back(seen_turned(taken.cloud, 25, taken.cloud.size()));
  }
  photographs.insert(photographs.end(), views.begin(), views.end());
  result.draw_picture("figure-2.3", side_by_side(photographs, 3));
  result.notes.emplace_back(
      "A virtual hand that moves before a white box, dual frequency of 6 steps: the mean of the "
      "frames, and the cloud from 25 degrees to the side, at three moments. The box and the hand "
      "are apart.");
  return result;
}

Reproduction figure_24(std::uint64_t seed) {
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}};
  Reproduction result;
  std::vector<Image<std::uint8_t>> views;
  for (const double moment : moments) {
    const HandScan taken = hand_scan(sequence, moment, seed);
    add_cells(taken, moment, result);
    views.push_back(seen_turned(taken.cloud, 0, taken.cloud.size()));
    views.push_back(seen_turned(taken.cloud, 25, taken.cloud.size()));
  }
  result.draw_picture("figure-2.4", side_by_side(views, 2));
  result.notes.emplace_back(
      "The virtual hand, 4 steps of one period, at three moments: from the camera and from 25 "
      "degrees to the side. `slipstream live --scene hand` shows it in motion.");
  return result;
}

}  // namespace

std::vector<Reproducible> hand_reproducibles() {
  return {{"figure", "2.3", "a moving hand before a box, 6 steps, dual frequency", figure_23},
          {"figure", "2.4", "point clouds of a moving hand, 4 steps", figure_24}};
}

}  // namespace slipstream
