// Pictures of noisy clouds beside pictures of the true surface. Tier: every change; seconds.
// scene_renderer_test.cpp draws made-up clouds without noise.
#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/image_file.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/virtual_scanner.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/scene_renderer.h"
#include "tests/view/made_up_cloud.h"

namespace slipstream::view::noisy_clouds_test {

TEST(Spacing, HardlyGrowsWithNoiseOfDepth) {
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

TEST(Spacing, IsThatAlongASlope) {
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
  double off;  ///< largest share of pixels off the true picture, twice what was measured
};

std::ostream& operator<<(std::ostream& to, const Mode& mode) {
  return to << mode.name;
}

class NoisyCloudTest : public testing::TestWithParam<Mode> {};

Image<Colour> drawn(const Cloud& cloud, const CloudExtent& extent, Size picture) {
  SceneRenderer scene;
  scene.set_extent(extent);
  scene.set_cloud({cloud.x, cloud.y, cloud.z, cloud.intensity}, nullptr, PointColour::reflectivity);
  const ViewSettings settings{.colour = PointColour::reflectivity,
                              .shaded = false,
                              .reflection = false,
                              .axes = false,
                              .grid = false,
                              .camera = fitted({}, extent.box, picture)};
  const opengl::RenderTarget target(picture);
  target.bind();
  scene.draw(settings, 0, {.size = picture});
  return opengl::read_pixels(picture);
}

TEST_P(NoisyCloudTest, LooksLikeTheTrueSurface) {
  std::unique_ptr<opengl::OffScreenContext> context;
  try {
    context = std::make_unique<opengl::OffScreenContext>();
  } catch (const WorldError& error) {
    GTEST_SKIP() << error.what();
  }

  // 1. A scan of the statue, and its cloud.
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = GetParam().strategy, .projector = scanner.projector.size};
  const VirtualScan scan = take_scan(scanner, scene_named("statue", scanner), pattern_set(sequence),
                                     {.ambient = 5, .noise_variance = 1.55});
  ReconstructSettings settings;
  settings.clean = CleanSettings::none();
  Cloud cloud;
  Engine(scanner, sequence, settings).cloud(scan.frames.views(), cloud);

  // 2. The same pixels where they truly are.
  Cloud truth = cloud;
  for_each_pixel_in_order(truth.size(), [&](int column, int row) {
    if (truth.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d point =
        scan.depth(column, row) * ray_through(scanner.camera, {column, row});
    truth.x(column, row) = static_cast<float>(point.x());
    truth.y(column, row) = static_cast<float>(point.y());
    truth.z(column, row) = static_cast<float>(point.z());
  });

  // 3. Both from the scanner's camera, at sizes of their own, on one scale.
  constexpr Size picture{640, 480};
  const CloudExtent of_truth = extent_of({truth.x, truth.y, truth.z, truth.intensity});
  CloudExtent of_cloud = of_truth;
  of_cloud.spacing = extent_of({cloud.x, cloud.y, cloud.z, cloud.intensity}).spacing;
  const Image<Colour> expected = drawn(truth, of_truth, picture);
  const Image<Colour> seen = drawn(cloud, of_cloud, picture);

  constexpr int tolerance = 40;  // grey levels
  std::size_t off = 0, lit = 0;
  for (std::size_t i = 0; i < seen.pixel_count(); ++i) {
    const Colour &one = seen.begin()[i], &other = expected.begin()[i];
    lit += other.green > 60 ? 1 : 0;
    off += std::abs(one.green - other.green) > tolerance ? 1 : 0;
  }
  const double share = static_cast<double>(off) / static_cast<double>(lit);
  const std::string file = testing::TempDir() + "noisy-" + GetParam().name + ".png";
  if (share > GetParam().off) write_image(file, seen);
  EXPECT_LE(share, GetParam().off) << "of " << lit << " pixels; picture: " << file;
  RecordProperty("share_off", std::to_string(share));
  std::printf("%s: %.3f off, spacing %.2f mm, true %.2f mm\n", GetParam().name, share,
              double{of_cloud.spacing}, double{of_truth.spacing});
}

INSTANTIATE_TEST_SUITE_P(
    Modes, NoisyCloudTest,
    testing::Values(Mode{"pmp3", PhaseMeasuring{.steps = 3, .frequency = 1}, 0.5},
                    Mode{"pmp4", PhaseMeasuring{.steps = 4, .frequency = 1}, 0.5},
                    Mode{"dual4", DualFrequency{.steps = 4, .high = 16, .low = 1}, 0.5},
                    Mode{"dual6", DualFrequency{.steps = 6, .high = 16, .low = 1}, 0.5},
                    Mode{"pcmp5", strategy_labelled("pcmp, steps 5"), 0.5}),
    testing::PrintToStringParamName());

}  // namespace slipstream::view::noisy_clouds_test
