// Residual maps by a scan's distances from the epipolar lines.
#include "reconstruct/epipolar_residual.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

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

/// A rig with a device that is off its model, and a scan by it.
struct ScanOfResidue {
  Scanner truth;
  Scan scan;
};

/// `device`: the one that is off, by `size` in three of its map's terms, pixels.
ScanOfResidue scan_of_residue(const Scanner& model, Lens Scanner::*device, double size) {
  Scanner truth = model;
  const Size picture = (model.*device).size;
  LensResidual& residual = (truth.*device).residual;
  residual.half = {picture.width / 2.0, picture.height / 2.0};
  residual.centre = residual.half;
  for (int i = 0; i < 10; ++i) {
    residual.terms.emplace_back(0, i == 2 || i == 5 || i == 7 ? size : 0);
  }

  const Sequence both{.strategy = DualFrequency{.steps = 8, .high = 32, .low = 1},
                      .both_axes = true};
  VirtualScan taken = take_scan(truth, scene_named("board", truth), pattern_set(both),
                                {.ambient = 5, .noise_variance = 1});
  Scan scan = merged({.frames = std::move(taken.frames), .sequence = both, .scanner = model});
  return {truth, std::move(scan)};
}

/// RMS distance of what the rig's projector lights at a depth, mm, from the epipolar lines of a
/// scanner, projector pixels.
double rms_off(const Scanner& truth, const Scanner& scanner, double depth) {
  constexpr int apart = 40;
  const Size camera = truth.camera.size, projector = truth.projector.size;

  double squares = 0;
  int count = 0;
  for (int row = apart; row < camera.height; row += apart) {
    for (int column = apart; column < camera.width; column += apart) {
      const Eigen::Vector3d point = depth * ray_through(truth.camera, {column, row});
      const Eigen::Vector2d lit = project(truth.projector, in_projector_frame(truth, point));
      const double distance =
          epipolar_distance(scanner, ray_through(scanner.camera, {column, row}),
                            lit.x() / projector.width, lit.y() / projector.height)
              .distance;
      squares += distance * distance;
      ++count;
    }
  }
  return std::sqrt(squares / count);
}

TEST(EpipolarResidual, TakesWhatTheProjectorIsOffForTheCameras) {
  const Scanner model = example_scanner({640, 480});
  const Scan scan = scan_of_residue(model, &Scanner::projector, 0.15).scan;
  const Distances before = distances_of(scan, model);
  const EpipolarResidual found =
      epipolar_residual(model, before.cloud, before.maps.epipolar_distance);
  EXPECT_EQ(found.scanner.projector, model.projector);
  EXPECT_FALSE(found.scanner.camera.residual.terms.empty());

  const Distances after = distances_of(scan, found.scanner);
  EXPECT_GE(found.degree, 2);
  EXPECT_LT(found.scores[static_cast<std::size_t>(found.degree)].deviation,
            found.scores.front().deviation / 4);
  EXPECT_LT(after.median_length, before.median_length / 2);
}

TEST(EpipolarResidual, HoldsAtOtherDepthsIfTheCameraIsOff) {
  const Scanner model = example_scanner({640, 480});
  const auto [truth, scan] = scan_of_residue(model, &Scanner::camera, 0.1);
  const Distances before = distances_of(scan, model);
  const EpipolarResidual found =
      epipolar_residual(model, before.cloud, before.maps.epipolar_distance);

  for (const double depth : {500.0, 700.0}) {
    EXPECT_LT(rms_off(truth, found.scanner, depth), rms_off(truth, model, depth) / 3) << depth;
  }
}

TEST(EpipolarResidual, IsRefusedWhereNothingIsLeft) {
  const Scanner model = example_scanner({640, 480});
  const Distances of = distances_of(scan_of_residue(model, &Scanner::projector, 0).scan, model);
  expect_error([&] { epipolar_residual(model, of.cloud, of.maps.epipolar_distance); },
               {"no residual map is supported"});

  Cloud few = of.cloud;
  std::fill(few.validity.begin() + 640 * 100, few.validity.end(), Validity::too_dark);
  expect_error([&] { epipolar_residual(model, few, of.maps.epipolar_distance); },
               {"blocks of 64 pixels", "requires 24"});
}

TEST(EpipolarResidual, IsRefusedOfASmallPicture) {
  const Size small{256, 192};
  expect_error(
      [&] { epipolar_residual(example_scanner(small), Cloud(small), Image<float>(small)); },
      {"pictures of 256x192 have 12 blocks of 64 pixels", "requires 24"});
}

}  // namespace slipstream::epipolar_residual_test
