// Right scans, real and virtual, with all mistakes that they may have.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "slipstream/check.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistake_lists.h"
#include "tests/check/real_sets.h"
#include "tests/every_strategy.h"

namespace slipstream::broken_scans_test {

/// A right scan, and its mistakes.
struct RightScan {
  std::string strategy;
  Scan scan;
  Image<double> depth{};  ///< true depth, mm; empty: that of the right scan itself
  Mistakes mistakes{};
  CheckSettings settings{};
  std::function<FrameSet()> take{};  ///< gives the frames, if they are not there yet
};

/// The settings of the captures: shared/data/README.md.
inline RightScan real_scan(const std::string& set) {
  const bool with_depths = set != "skull-alone";
  const std::filesystem::path folder = shared_data() / (with_depths ? set : "skull");
  RightScan right;
  if (set.starts_with("skull")) {
    right.scan = skull();
    if (with_depths) right.scan.scanner->calibrated_depths = skull_depths;
    const auto bent = [](double gamma) {
      return pixels(all_frames(6),
                    [=](double level, int, int) { return 255 * std::pow(level / 255, gamma); });
    };
    right.mistakes = {{"gamma of the frames 2.2", bent(2.2), {"gamma"}, "gamma"},
                      {"gamma of the frames 0.5", bent(0.5), {"gamma"}, "gamma"},
                      {"bands with unlike light",
                       pixels({3, 4, 5}, [](double level, int, int) { return 0.9 * level; }),
                       {"flickers"},
                       "light"}};
  } else if (set == "slmaster-mono") {
    right.scan = real_scan(
        folder, names_of(18, [](int n) { return fmt::format("frame_{:02}.png", n); }),
        GrayPhase{.steps = 12, .shifts = {std::numbers::pi, true}}, {1920, 1080}, "caliInfo.yml");
    right.scan.scanner->calibrated_depths = {600, 860};
  } else if (set == "cpsd-plane") {
    right.scan = real_scan(
        folder,
        names_of(48, [](int n) { return fmt::format("f{}_s{:02}.png", n / 12 + 1, n % 12 + 1); }),
        MultiFrequency{.steps = {12},
                       .periods = {1, 4, 16, 64},
                       .unwrapping = "hierarchical",
                       .shifts = {std::numbers::pi, true}},
        {1920, 1080});
    right.settings.photometry.response = MeasuredResponse{PowerLaw{2}, 2, 0.05};
  } else {
    std::vector<std::string> names =
        names_of(20, [](int n) { return fmt::format("pat{:02}.png", 12 + n); });
    right.scan = real_scan(
        folder, names, GrayCode{.bits = 10, .reference = "inverse", .stripes = 960}, {1920, 1080});
  }
  right.strategy = right.scan.sequence.strategy.name();
  for (Mistake& mistake : mistakes_of(right.scan)) right.mistakes.push_back(std::move(mistake));
  return right;
}

inline std::vector<Strategy> all_strategies() {
  std::vector<Strategy> all{MicroPhaseShifting{},
                            PhaseMeasuring{.steps = 3},
                            DualFrequency{.steps = 4, .high = 32},
                            DualFrequency{.steps = 3, .high = 16},
                            DualFrequency{.steps = 3, .high = 8},
                            GrayPhase{.steps = 12, .shifts = {std::numbers::pi, true}}};
  for (const Strategy& strategy : every_strategy()) all.push_back(strategy);
  return all;
}

inline VirtualWorld world_of(const std::string& scene, const std::string& world) {
  return virtual_world({.scene = scene, .camera = {320, 240}, .world = world, .seed = 3});
}

/// A scanner above the projector: its stripes along x hardly move with depth.
inline VirtualWorld above(VirtualWorld world, const std::string& scene) {
  world.scanner.rotation = Eigen::AngleAxisd(0.22, Eigen::Vector3d::UnitX()).toRotationMatrix();
  world.scanner.translation = Eigen::Vector3d(0, 176, 40);
  world.scene = scene_named(scene, world.scanner);
  return world;
}

/// Scans of every strategy under one light. Traces the scene once.
class WorldScans {
 public:
  WorldScans(const std::string& scene, const std::string& name)
      : is_ideal_(name == "ideal"),
        world_(world_of(scene, name)),
        seen_(take_scan(world_.scanner, world_.scene, pattern_set(PhaseMeasuring{}, Axis::x),
                        world_.photometry)),
        above_(above(world_, scene)) {
    if (is_ideal_) {
      from_above_ = take_scan(above_.scanner, above_.scene, pattern_set(PhaseMeasuring{}, Axis::x),
                              above_.photometry);
    }
  }

  [[nodiscard]] RightScan of(const Strategy& strategy) const {
    Sequence sequence{strategy, Axis::x, {}, world_.scanner.projector.size};
    Scan scan{.sequence = sequence, .scanner = as_calibrated(world_)};
    if (const Response& response = world_.photometry.response; response != Response{}) {
      scan.scanner->photometry.response = MeasuredResponse{response, 2.2, 0.01};
    }
    Mistakes mistakes = mistakes_of(scan);
    if (!is_code_alone(strategy)) {
      mistakes.push_back({"projector's gamma of 2.2",
                          [=, this](Scan& s) {
                            Photometry bent = world_.photometry;
                            bent.response = PowerLaw{2.2};
                            s.frames = take_again(seen_, pattern_set(s.sequence), bent);
                            s.scanner->photometry.response.reset();
                          },
                          {"gamma"},
                          "gamma"});
    }
    if (is_ideal_ && !is_code_alone(strategy)) {
      mistakes.push_back({"one-bit patterns in focus",
                          [=, this](Scan& s) {
                            s.sequence.binary = true;
                            s.frames =
                                take_again(seen_, pattern_set(s.sequence), world_.photometry);
                          },
                          {"one-bit"},
                          "one bit"});
      mistakes.push_back({"camera above the projector",
                          [=, this](Scan& s) {
                            s.frames =
                                take_again(from_above_, pattern_set(s.sequence), above_.photometry);
                            s.scanner = as_calibrated(above_);
                          },
                          {"patterns along y"},
                          "along the baseline"});
    }
    return {
        .strategy = strategy.name(),
        .scan = std::move(scan),
        .depth = seen_.depth,
        .mistakes = std::move(mistakes),
        .take = [=, this] { return take_again(seen_, pattern_set(sequence), world_.photometry); }};
  }

 private:
  static bool is_code_alone(const Strategy& strategy) {
    return strategy.layout().unwrapping->whole_stripes;
  }

  bool is_ideal_;
  VirtualWorld world_;
  VirtualScan seen_;
  VirtualWorld above_;
  VirtualScan from_above_{};
};

}  // namespace slipstream::broken_scans_test
