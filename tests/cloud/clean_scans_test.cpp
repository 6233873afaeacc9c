// What the default filters do to scans whose truth is known, and to a real one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "slipstream/codes/dual_frequency.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_scanner.h"
#include "tests/cloud/made_up_cloud.h"
#include "tests/shared_data.h"

namespace slipstream::clean_scans_test {

const CleanSettings raw = CleanSettings::none();

/// A small board before a large one, both facing the camera, turned in their planes.
Scene steps_in_depth(const Scanner& scanner, double step, double turn) {
  const WorkingVolume volume = working_volume(scanner);
  const auto board = [&](double z, double side) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(Eigen::Vector3d(0, 0, z));
    pose.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    return Body{.shape = Board{side, side}, .pose = pose};
  };
  return {board(volume.centre.z() - step / 2, 0.5 * volume.extent),
          board(volume.centre.z() + step / 2, 3 * volume.extent)};
}

/// The least distance in depth from a point to what is there in the nine pixels around it.
double distance_to_truth(const Image<double>& truth, float z, int column, int row) {
  double least = std::numeric_limits<double>::infinity();
  for (int r = std::max(0, row - 1); r <= std::min(truth.height() - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(truth.width() - 1, column + 1); ++c) {
      least = std::min(least, std::abs(truth(c, r) - z));
    }
  }
  return least;
}

/// A point that is more than a tenth of the step from both sides is mixed.
TEST(CleanScans, MixedPixelsOfDepthStepsGoAndGoodOnesStay) {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1}};
  for (const double step : {40.0, 80.0}) {
    std::size_t mixed = 0, mixed_left = 0, good = 0, good_left = 0;
    for (const double turn : {0.0, 0.2, 0.785}) {
      const VirtualScan scan =
          take_scan(scanner, steps_in_depth(scanner, step, turn),
                    pattern_set(sequence.strategy, sequence.axis, sequence.light),
                    {.ambient = 5, .noise_variance = 1.55, .rays = 16});
      Cloud all, clean;
      Engine(scanner, sequence, {.clean = raw}).cloud(scan.frames, all);
      Engine(scanner, sequence).cloud(scan.frames, clean);
      for (int row = 0; row < all.size().height; ++row) {
        for (int column = 0; column < all.size().width; ++column) {
          const float z = all.z(column, row);
          if (!(z > 0)) continue;
          const bool stays = clean.validity(column, row) == Validity::valid;
          if (distance_to_truth(scan.depth, z, column, row) > 0.1 * step) {
            ++mixed;
            mixed_left += stays ? 1 : 0;
          } else {
            ++good;
            good_left += stays ? 1 : 0;
          }
        }
      }
    }
    const auto share = [](std::size_t part, std::size_t of) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(of);
    };
    std::printf("step %.0f mm: of %zu mixed %.1f %% removed, of %zu good %.3f %%\n", step, mixed,
                share(mixed - mixed_left, mixed), good, share(good - good_left, good));
    EXPECT_GT(mixed, 200U) << step;
    EXPECT_GE(share(mixed - mixed_left, mixed), 95) << step;
    EXPECT_LE(share(good - good_left, good), 1) << step;
  }
}

TEST(CleanScans, LowTrustIsThatOfThePredictedSigma) {
  Scanner scanner = example_scanner({320, 240});
  scanner.photometry.noise_variance = 1.6;
  for (const Axis axis : {Axis::x, Axis::y}) {
    const Sequence sequence{.strategy = DualFrequency{}, .axis = axis};
    const VirtualScan scan = take_scan(scanner, scene_named("statue", scanner),
                                       pattern_set(sequence.strategy, axis, sequence.light),
                                       {.ambient = 5, .noise_variance = 1.5});
    for (const EngineKind kind : {EngineKind::fused, EngineKind::reference}) {
      Engine exact(scanner, sequence, {.engine = kind, .clean = raw});
      Cloud all, trusted;
      Maps maps;
      exact.cloud_and_maps(scan.frames, all, maps);
      const Uncertainty sigma = exact.uncertainty(all, maps, scan.frames);
      CleanSettings settings = raw;
      settings.largest_sigma = median_depth(sigma);
      Engine(scanner, sequence, {.engine = kind, .clean = settings}).cloud(scan.frames, trusted);
      std::size_t dropped = 0;
      for (std::size_t i = 0; i < all.z.pixel_count(); ++i) {
        if (all.validity.begin()[i] != Validity::valid) continue;
        const double ratio = sigma.z.begin()[i] / *settings.largest_sigma;
        const bool stays = trusted.validity.begin()[i] == Validity::valid;
        dropped += stays ? 0 : 1;
        if (ratio > 1.05) ASSERT_EQ(trusted.validity.begin()[i], Validity::low_trust);
        if (ratio < 0.95) ASSERT_TRUE(stays);
      }
      EXPECT_GT(dropped, point_count(all) / 3);
    }
  }
}

TEST(CleanScans, TheSkullsSpecksGoAndItsFaceStays) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const Sequence sequence{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}};
  const FrameSet frames = read_frames(images_in_folder(folder / "dual-frequency")).frames;
  Cloud all, clean;
  Engine(scanner, sequence, {.clean = raw}).cloud(frames, all);
  Engine(scanner, sequence).cloud(frames, clean);
  const auto linked = [](float a, float b) { return std::abs(a - b) < 5; };  // mm
  const Image<int> before = component_sizes(all, linked), after = component_sizes(clean, linked);
  const int face = *std::max_element(before.begin(), before.end());
  int specks = 0, lost = 0;
  for (std::size_t i = 0; i < before.pixel_count(); ++i) {
    specks += after.begin()[i] > 0 && after.begin()[i] < 200 ? 1 : 0;
    lost += before.begin()[i] == face && after.begin()[i] == 0 ? 1 : 0;
  }
  std::printf("the face has %d points, %d of which are lost: %.3f %%\n", face, lost,
              100.0 * lost / face);
  EXPECT_GT(face, 200000);
  EXPECT_EQ(specks, 0);
  EXPECT_LE(lost, 0.002 * face);
}

}  // namespace slipstream::clean_scans_test
