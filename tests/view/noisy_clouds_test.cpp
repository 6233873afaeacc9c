// Pictures of noisy clouds beside pictures of the true surface. Tier: every change; seconds.
// scene_renderer_test.cpp draws made-up clouds without noise.
#include <gtest/gtest.h>

#include "io/image_file.h"
#include "simulate/seen_scene.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/view/made_up_cloud.h"
#include "tests/view/off_screen.h"
#include "view/opengl.h"
#include "view/scene_renderer.h"

namespace slipstream::view::noisy_clouds_test {

TEST(NoisyClouds, SpacingHardlyGrowsWithNoiseOfDepth) {
  const Size size{160, 120};
  const MadeUpCloud exact = wall(size, 600);
  MadeUpCloud noisy = exact;
  for (std::size_t i = 0; i < noisy.z.pixel_count(); ++i) {
    // Along the pixel's ray, 8 mm either way: twice the spacing.
    const float along = 1 + (mixed(i) % 2 == 0 ? 8.0F : -8.0F) / 600;
    for (Image<float>* const part : {&noisy.x, &noisy.y, &noisy.z}) part->begin()[i] *= along;
  }

  const float spacing = extent_of(exact.images()).spacing;
  EXPECT_NEAR(spacing, 600.0F / 160, 0.01);
  EXPECT_NEAR(extent_of(noisy.images()).spacing, spacing, 0.1 * spacing);
}

TEST(NoisyClouds, SpacingIsThatAlongASlope) {
  MadeUpCloud slope = wall({160, 120}, 600);
  const float before = extent_of(slope.images()).spacing;
  for (std::size_t i = 0; i < slope.z.pixel_count(); ++i) {
    slope.z.begin()[i] += slope.x.begin()[i];  // 45 degrees
  }
  EXPECT_NEAR(extent_of(slope.images()).spacing, std::sqrt(2.0F) * before, 0.05 * before);
}

struct Mode {
  const char* name;
  Strategy strategy;
  double off;  ///< largest share of pixels off the true picture, about twice what was measured
};

std::ostream& operator<<(std::ostream& to, const Mode& mode) {
  return to << mode.name;
}

constexpr Size picture_size{640, 480};

CloudExtent extent_of_cloud(const Cloud& cloud) {
  return extent_of({cloud.x, cloud.y, cloud.z, cloud.intensity});
}

/// The points alone, from the front.
Image<Colour> drawn(const Cloud& cloud, const CloudExtent& extent) {
  SceneRenderer scene;
  scene.set_extent(extent);
  scene.set_cloud({cloud.x, cloud.y, cloud.z, cloud.intensity}, nullptr, PointColour::reflectivity);
  const ViewSettings settings{.colour = PointColour::reflectivity,
                              .shaded = false,
                              .reflection = false,
                              .axes = false,
                              .grid = false,
                              .camera = fitted({}, extent.box, picture_size)};
  const opengl::RenderTarget target(picture_size);
  target.bind();
  scene.draw(settings, 0, {.size = picture_size});
  return opengl::read_pixels(picture_size);
}

/// Pixels that differ by more than 40 grey levels, as a share of those where `expected` has points.
double share_off(const Image<Colour>& seen, const Image<Colour>& expected) {
  constexpr int tolerance = 40, background = 60;
  std::size_t off = 0, lit = 0;
  for (std::size_t i = 0; i < seen.pixel_count(); ++i) {
    const int one = seen.begin()[i].green, other = expected.begin()[i].green;
    lit += other > background ? 1 : 0;
    off += std::abs(one - other) > tolerance ? 1 : 0;
  }
  return static_cast<double>(off) / static_cast<double>(lit);
}

/// A cloud of the statue, without cleaning, and the same pixels where they truly are.
struct CloudAndTruth {
  Cloud cloud, truth;
};

CloudAndTruth reconstructed(const Strategy& strategy) {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = strategy, .projector = scanner.projector.size};
  const VirtualScan scan = take_scan(scanner, scene_named("statue", scanner), pattern_set(sequence),
                                     {.ambient = 5, .noise_variance = 1.55});
  ReconstructSettings settings;
  settings.clean = CleanSettings::none();
  CloudAndTruth made;
  Engine(scanner, sequence, settings).cloud(scan.frames.views(), made.cloud);

  made.truth = made.cloud;
  for_each_pixel_in_order(made.truth.size(), [&](int column, int row) {
    if (made.truth.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d point =
        scan.depth(column, row) * ray_through(scanner.camera, {column, row});
    made.truth.x(column, row) = static_cast<float>(point.x());
    made.truth.y(column, row) = static_cast<float>(point.y());
    made.truth.z(column, row) = static_cast<float>(point.z());
  });
  return made;
}

class NoisyCloudsDrawn : public OffScreen, public testing::WithParamInterface<Mode> {};

TEST_P(NoisyCloudsDrawn, LooksLikeTheTrueSurface) {
  const auto [cloud, truth] = reconstructed(GetParam().strategy);

  // One viewpoint and one scale; the size of points is each cloud's own.
  const CloudExtent of_truth = extent_of_cloud(truth);
  CloudExtent of_cloud = of_truth;
  of_cloud.spacing = extent_of_cloud(cloud).spacing;
  const Image<Colour> seen = drawn(cloud, of_cloud);
  const double share = share_off(seen, drawn(truth, of_truth));

  const std::string file = testing::TempDir() + "noisy-" + GetParam().name + ".png";
  if (!(share <= GetParam().off)) write_image(file, seen);
  EXPECT_LE(share, GetParam().off) << "points every " << of_cloud.spacing << " mm, truly "
                                   << of_truth.spacing << " mm; picture: " << file;
}

TEST_P(NoisyCloudsDrawn, WouldNotWithPointsTenTimesAsLarge) {
  const auto [cloud, truth] = reconstructed(GetParam().strategy);
  const CloudExtent of_truth = extent_of_cloud(truth);
  CloudExtent large = of_truth;
  large.spacing *= 10;
  EXPECT_GT(share_off(drawn(cloud, large), drawn(truth, of_truth)), 3 * GetParam().off);
}

// Depth is off by 8 mm with one period and by less than 1 mm with more. From the front, noise moves
// points on the picture by less than a pixel, so that most pixels off lie along silhouettes.
INSTANTIATE_TEST_SUITE_P(
    Modes, NoisyCloudsDrawn,
    testing::Values(Mode{"pmp3", PhaseMeasuring{.steps = 3, .frequency = 1}, 0.03},
                    Mode{"pmp4", PhaseMeasuring{.steps = 4, .frequency = 1}, 0.03},
                    Mode{"dual4", DualFrequency{.steps = 4, .high = 16, .low = 1}, 0.004},
                    Mode{"dual6", DualFrequency{.steps = 6, .high = 16, .low = 1}, 0.004},
                    Mode{"pcmp5", strategy_labelled("pcmp, steps 5"), 0.004}),
    testing::PrintToStringParamName());

}  // namespace slipstream::view::noisy_clouds_test
