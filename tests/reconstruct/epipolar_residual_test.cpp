// Residual maps by a scan's distances from the epipolar lines.
#include "reconstruct/epipolar_residual.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "reconstruct/epipolar.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"

namespace slipstream::epipolar_residual_test {

struct Distances {
  Cloud cloud;
  Maps maps;
  double median_length = 0;
};

/// The distances of a scan along both axes, as `scanner` has them.
Distances distances_of(Scan scan, const Scanner& scanner) {
  scan.scanner = scanner;
  const EngineSetup setup = setup_for(scan);
  Distances result;
  Engine(setup).cloud_and_maps(scan.frames, result.cloud, result.maps);
  result.median_length =
      check_epipolar(setup, scan.other_axis.front(), result.maps, result.cloud).median_length;
  return result;
}

/// A rig whose projector is off its model, and a scan by it.
Scan scan_of_residue(const Scanner& model, double size) {
  Scanner truth = model;
  truth.projector.residual = {.centre = {640, 400}, .half = {640, 400}};
  for (int i = 0; i < 10; ++i) {
    truth.projector.residual.terms.emplace_back(0, i == 2 || i == 5 || i == 7 ? size : 0);
  }
  const Sequence both{.strategy = DualFrequency{.steps = 8, .high = 32, .low = 1},
                      .both_axes = true};
  VirtualScan taken = take_scan(truth, scene_named("board", truth), pattern_set(both),
                                {.ambient = 5, .noise_variance = 1});
  return merged({.frames = std::move(taken.frames), .sequence = both, .scanner = model});
}

TEST(EpipolarResidual, FindsWhatTheProjectorIsOff) {
  const Scanner model = example_scanner({640, 480});
  const Scan scan = scan_of_residue(model, 0.15);
  const Distances before = distances_of(scan, model);
  const EpipolarResidual found =
      epipolar_residual(model, before.cloud, before.maps.epipolar_distance);
  const Distances after = distances_of(scan, found.scanner);
  EXPECT_GE(found.degree, 2);
  EXPECT_LT(found.scores[static_cast<std::size_t>(found.degree)].deviation,
            found.scores.front().deviation / 4);
  EXPECT_LT(after.median_length, before.median_length / 2);
}

TEST(EpipolarResidual, IsRefusedWhereNothingIsLeft) {
  const Scanner model = example_scanner({640, 480});
  const Distances of = distances_of(scan_of_residue(model, 0), model);
  expect_error([&] { epipolar_residual(model, of.cloud, of.maps.epipolar_distance); },
               {"no residual map is supported"});

  Cloud few = of.cloud;
  std::fill(few.validity.begin() + 640 * 100, few.validity.end(), Validity::too_dark);
  expect_error([&] { epipolar_residual(model, few, of.maps.epipolar_distance); },
               {"blocks of 64 pixels", "requires 24"});
}

}  // namespace slipstream::epipolar_residual_test
