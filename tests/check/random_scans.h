#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/named_scenes.h"
#include "slipstream/scan.h"
#include "slipstream/strategy.h"
#include "slipstream/unwrapping.h"
#include "slipstream/virtual_world.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream {

/// A right scan of the virtual scanner, and what was really there.
struct RandomScan {
  std::string name;
  Scan scan;
  VirtualScan truth;
  PatternSet patterns;
  Photometry photometry;
};

/// Scans with any of the strategies, rigs, scenes, lights, cameras: the same seed gives the same.
/// Nothing is wrong with them: the light is neither so strong that a pixel saturates nor so weak
/// that none is measured, and a response that is not linear is known.
class RandomScans {
 public:
  /// Of cameras of those bits.
  explicit RandomScans(std::uint64_t seed, std::vector<int> bits = {8, 8, 8, 10, 12})
      : random_(seed), bits_(std::move(bits)) {}

  RandomScan next() {
    Scanner scanner = random_scanner(static_cast<unsigned>(random_()), 0.1, {200, 160});
    const Strategy strategy = any_strategy();
    // Stripes across the baseline measure.
    const Eigen::Vector3d& base = scanner.translation;
    const Axis axis = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y;
    const std::string name(
        one_of(std::vector<std::string_view>{"board", "sphere", "boxes", "statue"}));
    // A cue cannot be corrected.
    const bool correctable =
        !strategy.layout().cue && order_source(strategy.layout()) != OrderSource::neighbours;
    const double gamma = correctable && between(0, 1) < 0.4 ? between(1.2, 2.6) : 1;
    const Photometry photometry{.ambient = between(0, 25),
                                .response = PowerLaw{gamma},
                                .noise_variance = between(0.2, 4),
                                .bits = one_of(bits_),
                                .seed = random_()};
    Scene scene = scene_named(name, scanner);
    const double alpha = between(0.35, 0.75);
    if (name != "statue") scene.front().texture = uniform_texture(alpha);
    // A response is corrected for patterns of the full range.
    const PatternLight light =
        gamma != 1 ? PatternLight{}
                   : PatternLight{.alpha_p = between(150, 200), .beta_p = between(0, 20)};
    VirtualWorld world{std::move(scanner), std::move(scene), photometry};
    RandomScan result{.name = label_of(strategy) + ", " + name,
                      .patterns = pattern_set(strategy, axis, light),
                      .photometry = photometry};
    result.truth = take_scan(world.scanner, world.scene, result.patterns, photometry);
    result.scan = {.frames = result.truth.frames,
                   .sequence = {strategy, axis, light, world.scanner.projector.size},
                   .scanner = as_calibrated(world)};
    if (gamma != 1) {
      result.scan.scanner->photometry.response = MeasuredResponse{PowerLaw{gamma}, gamma, 0.01};
    }
    result.scan.scanner->calibrated_depths = depths_in(result.truth);
    return result;
  }

 protected:
  double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  int whole(int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random_);
  }
  template <class Item>
  Item one_of(const std::vector<Item>& items) {
    return items[static_cast<std::size_t>(whole(0, static_cast<int>(items.size()) - 1))];
  }

 private:
  Strategy any_strategy() {
    switch (whole(0, 4)) {
      case 0:
        return make_strategy(
            "pmp", {{"steps", whole(3, 8)}, {"frequency", one_of<double>({1.0, 1.0, 0.9})}});
      case 1:
      case 2: {
        const double low = one_of<double>({1.0, 1.0, 0.8});
        return make_strategy("dual-frequency", {{"steps", whole(3, 8)},
                                                {"low_steps", whole(3, 6)},
                                                {"high", low * whole(4, 24)},
                                                {"low", low}});
      }
      case 3:
        return make_strategy("pcmp", {{"steps", whole(3, 8)}});
      default:
        return make_strategy("dual-frequency", {{"steps", 3}, {"high", 16}, {"low", 1}});
    }
  }

  /// As boards held all over the working volume would.
  static DepthRange depths_in(const VirtualScan& truth) {
    double nearest = 1e9, farthest = 0;
    for (const double z : truth.depth) {
      if (!std::isfinite(z)) continue;
      nearest = std::min(nearest, z);
      farthest = std::max(farthest, z);
    }
    return {0.95 * nearest, 1.05 * farthest};
  }

  std::mt19937_64 random_;
  std::vector<int> bits_;
};

}  // namespace slipstream
