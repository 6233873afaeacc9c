// What the default filters do to scans whose truth is known, and to a real one.
#include "slipstream/cleaner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <tbb/global_control.h>

#include "base/statistics.h"
#include "bench/vector_target.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "slipstream/cloud.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"
#include "tests/shared_data.h"

namespace slipstream::cleaner_test {

/// A cloud as a camera sees it whose pixels are 1 mm apart at a depth of 1 m. `depth`: of column
/// and row, mm; NaN for no point.
Cloud cloud_of_depths(Size size, const std::function<double(int, int)>& depth) {
  Cloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double z = depth(column, row);
      if (!(z > 0)) continue;
      cloud.x(column, row) = static_cast<float>(1e-3 * (column - size.width / 2) * z);
      cloud.y(column, row) = static_cast<float>(1e-3 * (row - size.height / 2) * z);
      cloud.z(column, row) = static_cast<float>(z);
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

bool same_points(const Cloud& a, const Cloud& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.size() == q.size() &&
           std::memcmp(p.begin(), q.begin(), p.pixel_count() * sizeof(*p.begin())) == 0;
  };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z) && same(a.validity, b.validity);
}

/// Pixels of each point's component: points beside each other in a row or a column are connected
/// where `linked(z, other z)`. 0 where there is none. By a plain flood.
Image<int> component_sizes(const Cloud& cloud, const std::function<bool(float, float)>& linked) {
  const Size size = cloud.size();
  Image<int> sizes(size);
  for (int start = 0; start < size.width * size.height; ++start) {
    if (sizes.begin()[start] != 0 || !(cloud.z.begin()[start] > 0)) continue;
    std::vector<int> found{start};
    sizes.begin()[start] = -1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const int column = found[i] % size.width, row = found[i] / size.width;
      for (const auto& [c, r] : {std::pair{column - 1, row}, std::pair{column + 1, row},
                                 std::pair{column, row - 1}, std::pair{column, row + 1}}) {
        if (c < 0 || r < 0 || c >= size.width || r >= size.height || sizes(c, r) != 0) continue;
        if (!(cloud.z(c, r) > 0) || !linked(cloud.z(column, row), cloud.z(c, r))) continue;
        sizes(c, r) = -1;
        found.push_back(r * size.width + c);
      }
    }
    for (const int pixel : found) sizes.begin()[pixel] = static_cast<int>(found.size());
  }
  return sizes;
}

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

CleanSettings only(const std::function<void(CleanSettings&)>& change) {
  CleanSettings settings = CleanSettings::none();
  change(settings);
  return settings;
}

/// A tilted plane before a wall under noise, with holes, specks and points off it.
Cloud disturbed_cloud(unsigned seed, Size size) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.2);
  std::uniform_real_distribution<double> share;
  return cloud_of_depths(size, [&](int column, int row) {
    const double chance = share(random);
    if (chance < 0.02) return nothing;
    const double off = chance > 0.99 ? 60 * share(random) : 0;
    const bool near = column > size.width / 3 && row > size.height / 4;
    return (near ? 800 + 0.5 * column : 900) + off + noise(random);
  });
}

std::size_t sum_of(const ValidityCounts& counts) {
  return std::accumulate(counts.begin() + 1, counts.end(), std::size_t{0});
}

TEST(Cleaner, ComponentsAreThoseOfAPlainFlood) {
  EXPECT_TRUE(rc::check("random masks", [] {
    const Size size{*rc::gen::inRange(40, 150), *rc::gen::inRange(20, 60)};
    const int smallest = *rc::gen::inRange(2, 40), step = *rc::gen::inRange(0, 150);
    const double share = 0.1 * *rc::gen::inRange(4, 10);
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    std::uniform_real_distribution<double> chance;
    Cloud cloud = cloud_of_depths(size, [&](int column, int) {
      return chance(random) > share ? nothing : column < step ? 800 : 1000;
    });
    const Cloud raw = cloud;
    const Image<int> sizes =
        component_sizes(raw, [](float a, float b) { return std::abs(a - b) < 100; });
    const ValidityCounts counts =
        Cleaner(only([&](auto& s) { s.smallest_component = smallest; }))(cloud);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < sizes.pixel_count(); ++i) {
      const bool stays = sizes.begin()[i] >= smallest;
      RC_ASSERT((cloud.validity.begin()[i] == Validity::valid) == stays);
      if (sizes.begin()[i] > 0 && !stays) ++dropped;
    }
    RC_ASSERT(counts[static_cast<std::size_t>(Validity::small_component)] == dropped);
  }));
}

TEST(Cleaner, TakesPointsAndNeitherAddsNorMovesAny) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Cloud raw = disturbed_cloud(seed, {static_cast<int>(101 + seed), 80});
    Cloud cloud = raw;
    const ValidityCounts counts = Cleaner()(cloud);
    EXPECT_EQ(point_count(raw) - point_count(cloud), sum_of(counts));
    EXPECT_EQ(counts[0], 0U);
    EXPECT_GT(sum_of(counts), 30U);
    for (std::size_t i = 0; i < raw.z.pixel_count(); ++i) {
      if (cloud.validity.begin()[i] == raw.validity.begin()[i]) {
        ASSERT_EQ(std::memcmp(raw.z.begin() + i, cloud.z.begin() + i, sizeof(float)), 0);
      } else {
        ASSERT_EQ(raw.validity.begin()[i], Validity::valid);
        ASSERT_TRUE(std::isnan(cloud.x.begin()[i]) && std::isnan(cloud.z.begin()[i]));
      }
    }
  }
}

TEST(Cleaner, FindsNothingInACleanCloud) {
  const auto plane = [](int column, int row) { return 800 + 0.3 * column + 0.2 * row; };
  Cloud cloud = cloud_of_depths({160, 120}, [&](int column, int row) {
    if (column % 40 == 20 && row % 30 == 15) return plane(column, row) + 15;
    if (column > 100 && column < 104) return nothing;
    return column < 60 ? 950 : plane(column, row);
  });
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 16U);
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 0U);
}

TEST(Cleaner, GivesTheSameOnAnyThreadsAndVectors) {
  const Cloud raw = disturbed_cloud(7, {333, 250});
  const auto cleaned = [&] {
    Cloud cloud = raw;
    Cleaner()(cloud);
    return cloud;
  };
  const Cloud expected = cleaned();
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_TRUE(same_points(cleaned(), expected));
  }
  for (const std::string& target : vector_targets()) {
    const OnlyVectorTarget alone(target);
    EXPECT_TRUE(same_points(cleaned(), expected)) << target;
  }
}

TEST(Cleaner, KeepsASteepSurface) {
  // 7 pixels deep for each pixel across, which is the least steep that is given up.
  Cloud cloud = cloud_of_depths({160, 60}, [](int column, int) { return 800 + 5.6 * column; });
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 0U);
}

TEST(Cleaner, NoneLeavesACloudAsItIs) {
  const Cloud raw = disturbed_cloud(3, {90, 70});
  Cloud cloud = raw;
  EXPECT_EQ(sum_of(Cleaner(CleanSettings::none())(cloud)), 0U);
  EXPECT_TRUE(same_points(cloud, raw));
  Cloud empty;
  EXPECT_EQ(sum_of(Cleaner()(empty)), 0U);
}

TEST(Cleaner, KeepsTheRegionAskedFor) {
  const auto kept_by = [](const std::function<void(CleanSettings&)>& change) {
    Cloud cloud = cloud_of_depths({100, 80}, [](int, int) { return 1000; });
    Cleaner clean(only(change));
    clean(cloud);
    return cloud;
  };
  EXPECT_EQ(point_count(kept_by([](auto& s) { s.outline = {{29, 49}, {10, 20}}; })), 20U * 30);
  const Cloud triangle = kept_by([](auto& s) { s.outline = {{10, 10}, {90, 10}, {10, 70}}; });
  EXPECT_EQ(triangle.validity(12, 50), Validity::valid);
  EXPECT_EQ(triangle.validity(80, 60), Validity::outside_region);
  EXPECT_NEAR(static_cast<double>(point_count(triangle)), 80 * 60 / 2, 90);
  // 1 mm for each pixel, from the middle.
  EXPECT_EQ(point_count(kept_by([](auto& s) {
              s.box = PointBox{{-4.5, -9.5, 900}, {4.5, 9.5, 1100}};
            })),
            9U * 19);
  EXPECT_EQ(point_count(kept_by([](auto& s) { s.box = PointBox{{-9, -9, 0}, {9, 9, 900}}; })), 0U);
}

TEST(Cleaner, FillsGapsOfOneSurfaceWithIt) {
  const auto plane = [](int column, int row) {
    return 1 / (1e-3 + 2e-7 * column - 1e-7 * row);  // what a plane is in a picture
  };
  const auto is_hole = [](int column, int row) {
    return std::abs(column - 30) <= 2 && std::abs(row - 30) <= 2;
  };
  Cloud cloud = cloud_of_depths({90, 70}, [&](int column, int row) {
    if (is_hole(column, row) || (column >= 60 && column < 67)) return nothing;
    return plane(column, row);
  });
  const ValidityCounts counts = Cleaner(only([](auto& s) { s.widest_gap = 5; }))(cloud);
  EXPECT_EQ(counts[0], 25U) << "the wide gap stays";
  for (int row = 28; row <= 32; ++row) {
    for (int column = 28; column <= 32; ++column) {
      EXPECT_NEAR(cloud.z(column, row), plane(column, row), 2e-3);
      EXPECT_NEAR(cloud.x(column, row), 1e-3 * (column - 45) * plane(column, row), 2e-3);
      EXPECT_EQ(cloud.validity(column, row), Validity::valid);
    }
  }
}

TEST(Cleaner, SmoothsNoiseAndKeepsEdges) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.5);
  const auto surface = [](int column) { return column < 50 ? 900 : 1000; };
  Cloud cloud =
      cloud_of_depths({100, 80}, [&](int column, int) { return surface(column) + noise(random); });
  const Cloud raw = cloud;
  Cleaner(only([](auto& s) { s.smoothing = 2; }))(cloud);
  const auto rms = [&](const Cloud& of, int first, int last) {
    double sum = 0;
    for (int row = 2; row < 78; ++row) {
      for (int column = first; column < last; ++column) {
        sum += std::pow(of.z(column, row) - surface(column), 2);
      }
    }
    return std::sqrt(sum / (76 * (last - first)));
  };
  EXPECT_LT(rms(cloud, 5, 45), 0.3 * rms(raw, 5, 45));
  EXPECT_LT(rms(cloud, 48, 52), 0.7 * rms(raw, 48, 52));
  // Along their rays.
  EXPECT_NEAR(cloud.x(20, 20) / cloud.z(20, 20), raw.x(20, 20) / raw.z(20, 20), 1e-6);
}

TEST(Cleaner, RefusesSettingsOutOfRange) {
  EXPECT_THROW(Cleaner({.largest_sigma = 0}), Error);
  EXPECT_THROW(Cleaner({.smallest_component = -1}), Error);
  EXPECT_THROW(Cleaner({.box = PointBox{}}), Error);
  EXPECT_THROW(Cleaner({.outline = {{1, 1}}}), Error);
  EXPECT_THROW(Cleaner({.widest_gap = -1}), Error);
  EXPECT_THROW(Cleaner({.smoothing = 11}), Error);
}

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

/// A point that is more than a tenth of the step from both sides is mixed.
TEST(Cleaner, CleanScansMixedPixelsOfDepthStepsGoAndGoodOnesStay) {
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
          if (std::abs(nearest_error(z, scan.depth, column, row)) > 0.1 * step) {
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

/// Pixels of a wire or a wall, with a depth within a twentieth of the step of the truth, or more
/// than a tenth off both.
struct WireCounts {
  std::size_t wire = 0, wire_kept = 0, off_kept = 0;
};

WireCounts count_wires(const VirtualScan& scan, const Cloud& all, const Cloud& clean, double wall,
                       double step) {
  WireCounts counts;
  for_each_pixel_in_order(all.size(), [&](int column, int row) {
    const float z = all.z(column, row);
    if (!(z > 0)) return;
    const bool stays = clean.validity(column, row) == Validity::valid;
    const double truth = scan.depth(column, row);
    if (truth < wall - step / 2 && std::abs(z - truth) < step / 20) {
      ++counts.wire;
      counts.wire_kept += stays ? 1 : 0;
    }
    const bool off = std::abs(nearest_error(z, scan.depth, column, row)) > step / 10;
    counts.off_kept += stays && off ? 1 : 0;
  });
  return counts;
}

TEST(Cleaner, CleanScansWiresBeforeAWallStay) {
  const Scanner scanner = example_scanner({320, 240});
  const WorkingVolume volume = working_volume(scanner);
  const double pixel = volume.centre.z() / scanner.camera.intrinsic(0, 0), step = 80;
  const double wall = volume.centre.z() + step / 2;
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1}};
  for (const double turn : {0.0, 0.1, 0.785, 1.571}) {
    for (const double width : {1.0, 2.0, 3.0}) {  // pixels
      const auto board = [&](double x, double z, double across, double along) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translate(Eigen::Vector3d(0, 0, z));
        pose.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
        pose.translate(Eigen::Vector3d(x, 0, 0));
        return Body{.shape = Board{across, along}, .pose = pose};
      };
      Scene scene{board(0, wall, 3 * volume.extent, 3 * volume.extent)};
      for (const double x : {-60.0, 0.0, 60.0}) {
        scene.push_back(board(x, wall - step, width * pixel, 0.6 * volume.extent));
      }
      const VirtualScan scan = take_scan(scanner, scene, pattern_set(sequence),
                                         {.ambient = 5, .noise_variance = 1.5, .rays = 16});
      Cloud all, clean;
      Engine(scanner, sequence, {.clean = raw}).cloud(scan.frames, all);
      Engine(scanner, sequence).cloud(scan.frames, clean);
      const WireCounts counts = count_wires(scan, all, clean, wall, step);
      std::printf(
          "wires of %.0f px, turned by %.2f: of %zu right points %zu stay, wrong ones %zu\n", width,
          turn, counts.wire, counts.wire_kept, counts.off_kept);
      EXPECT_EQ(counts.off_kept, 0U);
      // Narrow slanted ones are mixed with the wall nearly everywhere.
      const double least = width < 2 && turn > 0 && turn < 1 ? 0 : 0.55;
      EXPECT_GE(static_cast<double>(counts.wire_kept), least * static_cast<double>(counts.wire));
    }
  }
}

// In focus, dots of one bit are no noise of the camera, and a pixel at an edge sees a part of
// itself.
TEST(Cleaner, SigmaGrowsWithWhatNoiseDoesNotExplain) {
  VirtualWorld world{.scanner = example_scanner({320, 240})};
  world.scene = scene_named("sphere", world.scanner);
  const auto beyond = [&](const Sequence& sequence, const char* named, double deviations) {
    world.photometry = photometry_named(named);
    const VirtualScan scan =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    Engine engine(as_calibrated(world), sequence);
    Cloud cloud;
    Maps maps;
    engine.cloud_and_maps(scan.frames, cloud, maps);
    const Uncertainty sigma = engine.uncertainty(cloud, maps, scan.frames);
    double wrong = 0, count = 0;
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      if (cloud.validity(column, row) != Validity::valid) return;
      ++count;
      const double error = nearest_error(cloud.z(column, row), scan.depth, column, row);
      if (std::abs(error) > deviations * sigma.z(column, row)) ++wrong;
    });
    return wrong / count;
  };
  Sequence dots{.strategy = make_strategy("fast-three-step", {})};
  dots.binary = true;
  EXPECT_LT(beyond(dots, "ideal", 5), 0.01);
  EXPECT_LT(beyond({.strategy = DualFrequency{.steps = 8}}, "bench", 5), 0.002);
}

TEST(Cleaner, CleanScansLowTrustIsThatOfThePredictedNoise) {
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
        const double ratio = sigma.z_of_noise.begin()[i] / *settings.largest_sigma;
        const bool stays = trusted.validity.begin()[i] == Validity::valid;
        dropped += stays ? 0 : 1;
        if (ratio > 1.05) ASSERT_EQ(trusted.validity.begin()[i], Validity::low_trust);
        if (ratio < 0.95) ASSERT_TRUE(stays);
      }
      EXPECT_GT(dropped, point_count(all) / 3);
    }
  }
}

TEST(Cleaner, CleanScansTheSkullsSpecksGoAndItsFaceStays) {
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

}  // namespace slipstream::cleaner_test
