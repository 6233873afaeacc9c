// Right scans by cameras that expose and process pictures as those for people do.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "response/response_fit.h"
#include "simulate/camera_picture.h"
#include "tests/check/right_table.h"

namespace slipstream::right_table_processed_test {

std::vector<Image<double>> images_of(const FrameSet& frames) {
  std::vector<Image<double>> images;
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      Image<double>& image = images.emplace_back(view.size());
      for_each_pixel_in_order(view.size(), [&](int column, int row) {
        image(column, row) = static_cast<double>(view(column, row));
      });
    }
  });
  return images;
}

/// One scene of the bench, seen by cameras that expose and process pictures as those for people do.
class ProcessingCameras : public RandomScans {
 public:
  explicit ProcessingCameras(std::uint64_t seed) : RandomScans(seed) {
    world_.scanner = random_scanner(static_cast<unsigned>(whole(0, 1 << 30)), 0.1, {320, 240});
    name_ = one_of<std::string>({"board", "sphere", "boxes", "statue", "contrast", "wires"});
    world_.scene =
        name_ == "wires" ? wires(world_.scanner, 2, true) : scene_named(name_, world_.scanner);
    world_.photometry = photometry_named("bench");
    world_.photometry.rays = 4;
    world_.photometry.seed = seed;

    const Eigen::Vector3d& base = world_.scanner.translation;
    axis_ = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y;
    seen_ = take_scan(world_.scanner, world_.scene, pattern_set(PhaseMeasuring{}, axis_),
                      world_.photometry);
  }

  /// Each effect by itself, and all of them.
  std::vector<std::pair<std::string, Physics>> effects() {
    const Physics srgb = photometry_named("bench,tone-curve").physics;
    const auto curve = one_of<Response>({srgb.tone, PowerLaw{1 / 1.8}, logistic_curve(4, 0.5)});

    Physics toned = world_.photometry.physics, sharp = toned, exposed = toned, jpeg = toned;
    toned.tone = curve;
    sharp.sharpening = between(0.2, 1);
    exposed.auto_exposure = between(0, 0.1);
    jpeg.jpeg_quality = whole(75, 95);

    Physics all = toned;
    all.sharpening = sharp.sharpening;
    all.auto_exposure = exposed.auto_exposure;
    all.jpeg_quality = jpeg.jpeg_quality;
    return {{"tone curve", toned},
            {"sharpening", sharp},
            {"automatic exposure", exposed},
            {"JPEG", jpeg},
            {"all", all}};
  }

  /// What reaches the sensor.
  [[nodiscard]] std::vector<Image<double>> light_of(const Strategy& strategy) const {
    Photometry light = world_.photometry;
    light.bits.reset();
    light.physics.full_well = light.physics.read_noise = light.physics.row_noise = 0;
    light.physics.dark_spread = light.physics.sensitivity_spread = 0;
    return images_of(take_again(seen_, pattern_set(strategy, axis_), light));
  }

  [[nodiscard]] RightScan scan_of(const Strategy& strategy, std::vector<Image<double>> light,
                                  const std::string& effect, const Physics& physics) const {
    RightScan right{.name = fmt::format("{}, {}, {}", label_of(strategy), name_, effect),
                    .strategy = fmt::format("{}, {}", label_of(strategy), effect),
                    .world = world_};
    right.world.photometry.physics = physics;
    right.scan = {.frames = camera_pictures(std::move(light), 0, right.world.photometry),
                  .sequence = {strategy, axis_, {}, world_.scanner.projector.size},
                  .scanner = as_calibrated(right.world)};
    right.scan.scanner->calibrated_depths.reset();
    right.truths.push_back(seen_);
    return right;
  }

 private:
  VirtualWorld world_;
  VirtualScan seen_;
  Axis axis_ = Axis::x;
  std::string name_;
};

/// Warnings that are right: a tone curve bends the phase as a gamma does, automatic exposure
/// flickers, and fringes may be fainter than the check asks for.
bool is_earned(const Finding& finding, const RightScan& right) {
  const Physics& physics = right.world.photometry.physics;
  const bool has_phase = !right.scan.sequence.strategy.layout().bands.empty();
  if (finding.severity == Severity::wrong) return false;
  if (finding.kind == FindingKind::low_modulation || finding.kind == FindingKind::mostly_dark)
    return true;
  if (blames(finding, CauseKind::gamma)) return has_phase && !is_linear(physics.tone);
  return blames(finding, CauseKind::flicker) && physics.auto_exposure > 0;
}

/// Cameras that process their pictures, 40 scans each.
class RightTableProcessedScans : public RightTableScans {};

TEST_P(RightTableProcessedScans, AreLeftInPeace) {
  if (GetParam().is_share()) return judge_share(1000);

  ProcessingCameras cameras(static_cast<std::uint64_t>(4052 + GetParam().number));
  for (const Strategy& strategy : std::vector<Strategy>{
           GrayCode{.bits = 9, .reference = "inverse"},
           GrayCode{.bits = 9, .reference = "white-black"}, GrayPhase{},
           GrayPhase{.periods = 16, .reference = "inverse"}, DualFrequency{.steps = 4, .high = 16},
           DualFrequency{.steps = 5, .low_steps = 5, .high = 16}, MultiFrequency{.steps = {4}},
           MicroPhaseShifting{.periods = {25, 23, 22, 19}}}) {
    const std::vector<Image<double>> light = cameras.light_of(strategy);

    for (const auto& [effect, physics] : cameras.effects()) {
      RightScan right = cameras.scan_of(strategy, light, effect, physics);
      const std::vector<Finding> found = check_and_repair(right.scan).findings;
      const bool earned = std::ranges::all_of(
          found, [&](const Finding& finding) { return is_earned(finding, right); });
      judge(right, found, earned ? effect : true_cause(right, found));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Day, RightTableProcessedScans, testing::ValuesIn(set_of(0, 1)), named);
INSTANTIATE_TEST_SUITE_P(Night1, RightTableProcessedScans, testing::ValuesIn(set_of(1, 16)), named);
INSTANTIATE_TEST_SUITE_P(Night2, RightTableProcessedScans, testing::ValuesIn(set_of(16, 31)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night3, RightTableProcessedScans, testing::ValuesIn(set_of(31, 46)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night4, RightTableProcessedScans, testing::ValuesIn(set_of(46, 61)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night5, RightTableProcessedScans, testing::ValuesIn(set_of(61, 75)),
                         named);

}  // namespace slipstream::right_table_processed_test
