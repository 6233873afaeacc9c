#pragma once

#include <string>

#include "slipstream/check.h"
#include "slipstream/scan.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream {

/// A right scan of a scene along x, 320x240, with little ambient light and noise. `response`: of
/// projector and camera; the scanner does not know it.
inline Scan scene_scan(const std::string& scene, const Strategy& strategy,
                       const Response& response = PowerLaw{1}, bool binary = false) {
  VirtualWorld world{.scanner = example_scanner({320, 240})};
  world.photometry = {.ambient = 3, .response = response, .noise_variance = 1.5};

  Sequence sequence{.strategy = strategy, .projector = world.scanner.projector.size};
  sequence.binary = binary;
  const VirtualScan taken =
      scan_of_scene(scene, world.scanner, pattern_set(sequence), world.photometry);
  return {.frames = taken.frames, .sequence = sequence, .scanner = as_calibrated(world)};
}

/// The findings of a right scan of a world along x.
inline ScanFindings findings_of(const VirtualWorld& world, const Strategy& strategy) {
  const VirtualScan taken =
      take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x), world.photometry);
  return check_scan({.frames = taken.frames,
                     .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
                     .scanner = as_calibrated(world)});
}

/// The findings, a line each.
inline std::string told(const ScanFindings& found) {
  std::string text;
  for (const Finding& finding : found.findings) text += text_of(finding) + "\n";
  return text;
}

}  // namespace slipstream
