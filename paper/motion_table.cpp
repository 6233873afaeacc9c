#include "paper/motion_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

constexpr double frames_per_second = 120;
constexpr std::array<double, 5> speeds{0, 1, 5, 20, 50};  // mm/s

struct Measured {
  const char* name;
  Sequence sequence;
};

std::vector<Measured> measured_by() {
  const Strategy four = PhaseMeasuring{4, 1};
  return {
      {"4 steps", {.strategy = four}},
      {"4 steps, K = 2", {.strategy = four, .motion = 2}},
      {"4 steps, K = 4", {.strategy = four, .motion = 4}},
      {"2+1", {.strategy = TwoPlusOne{}}},
      {"one frame", {.strategy = FourierProfilometry{.frequency = 32}}},
      {"PCMP of 5 steps", {.strategy = PhaseChannelMultiplexing{.steps = 5}}},
      {"PCMP of 5 steps, K = 2", {.strategy = PhaseChannelMultiplexing{.steps = 5}, .motion = 2}}};
}

/// Whether no other surface and no shadow is within two pixels.
bool inside(const VirtualScan& scan, int column, int row) {
  constexpr int around = 2;
  constexpr double edge = 5;  // mm
  if (column < around || row < around || column + around >= scan.depth.width() ||
      row + around >= scan.depth.height()) {
    return false;
  }
  for (int y = row - around; y <= row + around; ++y) {
    for (int x = column - around; x <= column + around; ++x) {
      const double step = scan.depth(x, y) - scan.depth(column, row);
      if (!(std::abs(step) < edge) || std::isnan(scan.coordinate(x, y))) return false;
    }
  }
  return true;
}

/// Settings of a user who knows the depth range, which some strategies need.
ReconstructSettings settings_for(const VirtualScan& scan) {
  constexpr double beyond = 5;  // mm
  ReconstructSettings settings{.clean = CleanSettings::none()};
  for (const double depth : scan.depth) {
    if (std::isnan(depth)) continue;
    settings.nearest = std::min(settings.nearest.value_or(depth), depth - beyond);
    settings.farthest = std::max(settings.farthest.value_or(depth), depth + beyond);
  }
  return settings;
}

/// 90th percentile of the depth errors, mm, relative to the depth in the middle of the scan, away
/// from edges, without noise or quantisation. Nullopt if there are no points.
std::optional<double> depth_error(const Scanner& scanner, Scene scene, const Sequence& sequence,
                                  const Eigen::Vector3d& motion) {
  const Photometry exact{.noise_variance = 0, .bits = std::nullopt};
  const PatternSet patterns = pattern_set(sequence);
  const double half = 0.5 * (patterns.count - 1);
  for (Body& body : scene) body.motion.step = motion;
  const auto seen = [&](double time) {
    return take_scan(scanner, scene, pattern_alone(patterns, 0), exact, time);
  };
  const VirtualScan first = seen(-half), last = seen(half),
                    middle = take_scan(scanner, scene, patterns, exact, -half);
  Cloud cloud;
  Engine(scanner, sequence, settings_for(middle)).cloud(middle.frames, cloud);
  std::vector<double> errors;
  for (int row = 0; row < cloud.z.height(); ++row) {
    for (int column = 0; column < cloud.z.width(); ++column) {
      const double error = cloud.z(column, row) - middle.depth(column, row);
      if (!std::isfinite(error) || !inside(first, column, row) || !inside(middle, column, row) ||
          !inside(last, column, row)) {
        continue;
      }
      errors.push_back(std::abs(error));
    }
  }
  if (errors.empty()) return std::nullopt;
  const auto at =
      errors.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(errors.size()));
  std::nth_element(errors.begin(), at, errors.end());
  return *at;
}

Reproduction motion_table() {
  const Scanner scanner = example_scanner({320, 240});
  Reproduction result;
  for (const char* name : {"sphere", "statue"}) {
    Scene scene = scene_named(name, scanner);
    for (Body& body : scene) body.texture = uniform_texture(0.8);
    for (const auto& [way, direction] : {std::pair("along the view", Eigen::Vector3d(0, 0, 1)),
                                         std::pair("across the view", Eigen::Vector3d(1, 0, 0))}) {
      std::vector<PlotLine> lines;
      for (const Measured& measured : measured_by()) {
        PlotLine line{.label = measured.name, .x = {}, .y = {}};
        for (const double speed : speeds) {
          const auto error =
              depth_error(scanner, scene, measured.sequence, speed / frames_per_second * direction);
          if (!error) continue;
          result.add(fmt::format("90 % of depth errors, {} {}, {}, mm", name, way, measured.name),
                     {{"mm/s", speed}}, std::nullopt, std::nullopt, *error);
          if (speed > 0) line.add(speed, *error);
        }
        lines.push_back(std::move(line));
      }
      result.draw(
          fmt::format("motion-{}-{}", name, std::string(way).substr(0, way[2] == 'o' ? 5 : 6)),
          fmt::format("A {} moving {}, {:g} frames/s", name, way, frames_per_second), "mm/s",
          "90 % of depth errors, mm", PlotScale::logarithmic, std::move(lines));
    }
  }
  result.notes.push_back(
      "Without noise; the 4 steps have one period. Errors are relative to the depth in the middle "
      "of each scan, away from edges, on surfaces of uniform paint. With one frame the depth "
      "range gives the fringe order, which is ambiguous for the statue in front of its wall.");
  return result;
}

}  // namespace

std::vector<Reproducible> motion_reproducibles() {
  return {{"experiment", "motion", "moving objects, by frames and weights",
           [](std::uint64_t) { return motion_table(); }}};
}

}  // namespace slipstream
