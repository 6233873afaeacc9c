// Right scans of every strategy are left in peace.
#include "tests/check/right_table.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "response/response_fit.h"
#include "simulate/camera_picture.h"
#include "simulate/seen_scene.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/virtual_world.h"
#include "tests/every_strategy.h"

namespace slipstream::right_table_test {

std::vector<Strategy> every_and_default_strategy() {
  std::vector<Strategy> all = every_strategy();
  for (const std::string_view name : strategy_names()) {
    all.push_back(make_strategy(std::string(name), {}));
  }
  return all;
}

class RightTable : public RandomScans {
 public:
  using RandomScans::RandomScans;

  /// Of the strategies in turn; every fifth with other settings of a few.
  RightScan next_right(std::size_t number) {
    static const std::vector<Strategy> strategies = every_and_default_strategy();
    RightScan right;
    if (number % 5 == 4) {
      RandomScan random = next();
      right = {.name = random.name,
               .strategy = random.scan.sequence.strategy.name() + ", other settings",
               .scan = std::move(random.scan)};
      right.truths.push_back(std::move(random.truth));
      right.world.photometry = random.photometry;
      return right;
    }
    const Strategy& strategy = strategies[(number - number / 5) % strategies.size()];
    right.strategy = label_of(strategy);
    Sequence sequence{.strategy = strategy};
    Size camera = one_of<Size>({{96, 72},
                                {96, 72},
                                {96, 72},
                                {128, 96},
                                {128, 96},
                                {160, 120},
                                {160, 120},
                                {240, 180},
                                {320, 240},
                                {640, 480}});
    // A period has three pixels or more.
    while (camera.width < 3 * highest_frequency(strategy.layout()) ||
           camera.height < 3 * carrier_periods(strategy.layout())) {
      camera = {camera.width + 32, camera.height + 24};
    }
    // Along y the projector has fewer pixels than the finest code has stripes.
    const auto& code = strategy.layout().code;
    do {
      right.world.scanner = random_scanner(static_cast<unsigned>(whole(0, 1 << 30)), 0.1, camera);
      const Eigen::Vector3d& base = right.world.scanner.translation;
      sequence.axis = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y;
      sequence.projector = right.world.scanner.projector.size;
    } while (code && code->stripes > length_along(sequence.axis, sequence.projector));
    const auto kind =
        one_of<std::string>({"ideal", "ideal", "ideal", "bench", "bench", "bench", "harsh"});
    // A cue cannot be corrected.
    const bool correctable =
        !strategy.layout().cue && order_source(strategy.layout()) != OrderSource::neighbours;
    right.world.photometry = photometry_named(kind + (correctable ? "" : ",no-response"));
    Photometry& photometry = right.world.photometry;
    photometry.rays = std::min(photometry.rays, 4);
    photometry.physics.bounces = 0;
    photometry.bits = one_of<int>({8, 8, 10, 12, 14});
    photometry.seed = static_cast<std::uint64_t>(whole(0, 1 << 30));
    if (kind == "ideal") {
      photometry.ambient = between(0, 25);
      photometry.noise_variance = std::pow(10, between(-2, 0.6));
    }
    const auto scene = one_of<std::string>(
        {"board", "sphere", "boxes", "statue", "statue", "contrast", "wires", "wires"});
    right.world.scene = scene == "wires"
                            ? wires(right.world.scanner, between(1, 3), between(0, 1) < 0.5)
                            : scene_named(scene, right.world.scanner);
    try_exposures(sequence, scene == "contrast" ? 0.8 : 0.3);
    const bool two_cameras = !strategy.is_spectral() && between(0, 1) < 0.15;
    right.name =
        fmt::format("{}, {}, {}, {} wide, {} bits, {} exposures, {} motion{}", right.strategy, kind,
                    scene, camera.width, *photometry.bits, sequence.exposures.size(),
                    sequence.motion, two_cameras ? ", two cameras" : "");
    const auto take = [&](const VirtualWorld& world) {
      right.truths.push_back(
          take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry));
      return scan_of(world, sequence, right.truths.back().frames);
    };
    right.scan = take(right.world);
    if (two_cameras) right.scan.further_cameras.push_back(take(seen_from_second(right.world)));
    return right;
  }

 private:
  /// Several exposures, or a window of motion, if the sequence allows them.
  void try_exposures(Sequence& sequence, double share) {
    const auto keep = [&](Sequence changed) {
      try {
        require_mergeable(changed);
        sequence = std::move(changed);
      } catch (const Error&) {
        return;
      }
    };
    Sequence changed = sequence;
    if (between(0, 1) < share) {
      changed.exposures = one_of<std::vector<double>>({{1, 4}, {1, 4, 16}, {0.25, 1, 4}});
      keep(changed);
    } else if (sequence.strategy.name() != "pcps" && between(0, 1) < 0.5) {
      // A window of pcps, whose cue depends on the phase, gives few orders.
      changed.motion = one_of<int>({2, 4});
      keep(changed);
    }
  }

  static Scan scan_of(const VirtualWorld& world, const Sequence& sequence, const FrameSet& frames) {
    Scan scan = merged({.frames = frames, .sequence = sequence, .scanner = as_calibrated(world)});
    scan.scanner->calibrated_depths.reset();
    const auto* const power = std::get_if<PowerLaw>(&world.photometry.response);
    if (power != nullptr && power->gamma != 1) {
      scan.scanner->photometry.response = MeasuredResponse{*power, power->gamma, 0.01};
    }
    return scan;
  }
};

// Blur mixes the coordinates on both sides of a thing of a few pixels: it shows no slope. The table
// has too few scans of wires alone to meet those that were refused.
TEST(RightTable, WiresAloneAreLeftInPeace) {
  const Strategy strategy = make_strategy("gray-phase", {});
  for (const unsigned seed : {2U, 8U, 11U, 17U}) {
    VirtualWorld world{.scanner = random_scanner(seed, 0.1, {640, 480})};
    const Eigen::Vector3d& base = world.scanner.translation;
    const Sequence sequence{.strategy = strategy,
                            .axis = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y,
                            .projector = world.scanner.projector.size};
    world.scene = wires(world.scanner, 1 + seed % 8 / 4.0, false);
    world.photometry = photometry_named("harsh,no-response");
    world.photometry.rays = 4;
    world.photometry.physics.bounces = 0;
    world.photometry.bits = 12;
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    Scan scan{.frames = taken.frames, .sequence = sequence, .scanner = as_calibrated(world)};
    scan.scanner->calibrated_depths.reset();
    for (const Finding& finding : check_scan(scan).findings) {
      ADD_FAILURE() << "seed " << seed << ": " << text_of(finding);
    }
  }
}

/// Scan `number` of the table: each hundred scans come one after the other from one seed.
RightScan right_scan(int number) {
  constexpr int hundred = 100;
  static std::optional<RightTable> scans;
  static int next = -1;

  if (number != next || number % hundred == 0) {
    scans.emplace(static_cast<std::uint64_t>(2026 + number / hundred));
    for (next = number - number % hundred; next < number; ++next) {
      scans->next_right(static_cast<std::size_t>(next));
    }
  }
  next = number + 1;
  return scans->next_right(static_cast<std::size_t>(number));
}

TEST_P(RightTableScans, AreLeftInPeace) {
  if (GetParam().is_share()) return judge_share(600);
  RightScan right = right_scan(GetParam().number);
  const std::vector<Finding> found = check_and_repair(right.scan).findings;
  judge(right, found, found.empty() ? "" : true_cause(right, found));
}

INSTANTIATE_TEST_SUITE_P(Day1, RightTableScans, testing::ValuesIn(set_of(0, 100)), named);
INSTANTIATE_TEST_SUITE_P(Day2, RightTableScans, testing::ValuesIn(set_of(100, 200)), named);
INSTANTIATE_TEST_SUITE_P(Day3, RightTableScans, testing::ValuesIn(set_of(200, 300)), named);
INSTANTIATE_TEST_SUITE_P(Night1, RightTableScans, testing::ValuesIn(set_of(300, 800)), named);
INSTANTIATE_TEST_SUITE_P(Night2, RightTableScans, testing::ValuesIn(set_of(800, 1300)), named);
INSTANTIATE_TEST_SUITE_P(Night3, RightTableScans, testing::ValuesIn(set_of(1300, 1900)), named);
INSTANTIATE_TEST_SUITE_P(Night4, RightTableScans, testing::ValuesIn(set_of(1900, 2400)), named);
INSTANTIATE_TEST_SUITE_P(Night5, RightTableScans, testing::ValuesIn(set_of(2400, 3000)), named);

}  // namespace slipstream::right_table_test
