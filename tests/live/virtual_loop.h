#pragma once

#include <string_view>
#include <vector>

#include "slipstream/engine.h"
#include "slipstream/frame_source.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// Parameters of a loop of virtual camera frames.
struct VirtualLoop {
  Size size{64, 48};
  std::string_view scene = "statue";
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();  ///< mm per frame
  int cycles = 3;
  Photometry photometry{.ambient = 5, .noise_variance = 1.5};
};

inline EngineSetup scan_of(const Strategy& strategy, Size size = {64, 48}) {
  return {.scanner = example_scanner(size), .sequence = {.strategy = strategy}};
}

inline std::vector<Frame> frames_of(const PatternSet& patterns, const VirtualLoop& loop = {}) {
  const Scanner scanner = example_scanner(loop.size);
  Scene scene = scene_named(loop.scene, scanner);
  for (Body& body : scene) body.motion.step = loop.motion;
  return virtual_frames(scanner, scene, patterns, loop.photometry, loop.cycles);
}

inline std::vector<Frame> frames_of(const Strategy& strategy, const VirtualLoop& loop = {}) {
  return frames_of(pattern_set(strategy, Axis::x), loop);
}

}  // namespace slipstream
