// Each effect of the virtual world against what optics and statistics say of it.
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream::physics_test {

constexpr Size picture{96, 72};

Scanner scanner() {
  return example_scanner(picture);
}

/// A board across the camera's axis where projector and camera look.
Scene board(const Texture& texture = uniform_texture(0.8)) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(working_volume(scanner()).centre);
  return {Body{.shape = Board{2000, 2000}, .pose = pose, .texture = texture}};
}

/// Four steps of a sinusoid of so many periods.
PatternSet fringes(double periods) {
  return {.count = 4, .light = {}, .shape = [=](int n, double y) {
            return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (periods * y - n / 4.0));
          }};
}

PatternSet flat(double shape, int count = 1) {
  return {.count = count, .light = {}, .shape = [=](int, double) { return shape; }};
}

Image<double> frame_of(const VirtualScan& scan, int n = 0) {
  Image<double> image(scan.frames.size());
  scan.frames.visit([&](const auto& frames) {
    const auto* const first = frames[static_cast<std::size_t>(n)].row(0);
    std::copy(first, first + image.pixel_count(), image.begin());
  });
  return image;
}

Image<double> frame(const Scene& scene, const PatternSet& patterns, const Physics& physics,
                    int n = 0) {
  return frame_of(take_scan(scanner(), scene, patterns, {.bits = std::nullopt, .physics = physics}),
                  n);
}

double modulation(const Scene& scene, double periods, const Physics& physics, int column, int row) {
  const VirtualScan scan =
      take_scan(scanner(), scene, fringes(periods), {.bits = std::nullopt, .physics = physics});
  return std::hypot(frame_of(scan, 0)(column, row) - frame_of(scan, 2)(column, row),
                    frame_of(scan, 1)(column, row) - frame_of(scan, 3)(column, row)) /
         2;
}

double mean(const Image<double>& image) {
  double sum = 0;
  for (const double value : image) sum += value;
  return sum / static_cast<double>(image.pixel_count());
}

TEST(Physics, EveryEffectIsPutInAndLeftOutByName) {
  const Photometry ideal = photometry_named("ideal"), harsh = photometry_named("harsh");
  const auto differ = [](const Photometry& a, const Photometry& b) {
    return a.physics != b.physics || a.rays != b.rays || a.response != b.response ||
           a.noise_variance != b.noise_variance;
  };
  // No world has the effects of cameras that make pictures for people.
  const std::set<std::string_view> of_no_world{"auto-exposure", "tone-curve", "sharpening", "jpeg"};
  std::string all_out = "harsh";
  for (const std::string_view name : effect_names()) {
    SCOPED_TRACE(name);
    const std::string effect(name);
    EXPECT_TRUE(differ(photometry_named("ideal," + effect), ideal));
    EXPECT_EQ(differ(photometry_named("harsh,no-" + effect), harsh), !of_no_world.contains(name));
    EXPECT_FALSE(differ(photometry_named("ideal," + effect + ",no-" + effect), ideal));
    all_out += ",no-" + effect;
  }
  EXPECT_FALSE(differ(photometry_named(all_out), ideal));
  EXPECT_FALSE(photometry_named("bench").physics == Physics{});
  for (const char* wrong : {"", "bensh", "bench,fog", "harsh,no-", "no-gloss"}) {
    EXPECT_THROW(photometry_named(wrong), Error) << wrong;
  }
}

TEST(Physics, TheProjectorsBlurTakesModulationAsAGaussianDoes) {
  const double periods = 80, period = scanner().projector.size.width / periods;
  for (const double blur : {1.0, 2.0, 3.5}) {
    const double expected = modulation(board(), periods, {}, 48, 36) *
                            std::exp(-2 * std::pow(std::numbers::pi * blur / period, 2));
    EXPECT_NEAR(modulation(board(), periods, {.projector = {.blur = blur}}, 48, 36), expected,
                0.02 * expected)
        << blur;
  }
}

TEST(Physics, DefocusGrowsFromTheWorkingDistance) {
  EXPECT_DOUBLE_EQ((Sharpness{.blur = 0.6, .defocus = 4}.at(1)), 0.6);
  EXPECT_DOUBLE_EQ((Sharpness{.blur = 0.6, .defocus = 8}.at(1.1)), 1);
  EXPECT_DOUBLE_EQ((Sharpness{.blur = 0.6, .defocus = 8}.at(0.9)), 1);
}

TEST(Physics, TheCamerasBlurSoftensAnEdgeOfTheSurface) {
  const Texture edge = [](const Eigen::Vector3d& p) { return p.x() < 0 ? 0.2 : 0.8; };
  const Image<double> sharp = frame(board(edge), flat(1), {});
  const Image<double> soft = frame(board(edge), flat(1), {.camera = {.blur = 2}});
  const int row = 36;
  int between_sharp = 0, between_soft = 0;
  for (int column = 20; column < 76; ++column) {
    const auto between = [](double value) { return value > 60 && value < 190; };
    between_sharp += between(sharp(column, row)) ? 1 : 0;
    between_soft += between(soft(column, row)) ? 1 : 0;
  }
  EXPECT_EQ(between_sharp, 0);
  EXPECT_GE(between_soft, 4);
  EXPECT_NEAR(mean(soft), mean(sharp), 0.02 * mean(sharp));
}

TEST(Physics, ProjectorPixelsAreEven) {
  // A ramp of two grey levels for each projector pixel: between them nothing is seen.
  const int width = scanner().projector.size.width;
  const PatternSet ramp{.count = 1, .light = {}, .shape = [=](int, double y) {
                          return std::fmod(y * width + 0.5, 100) / 100;
                        }};
  std::set<long> levels;
  for (const double value : frame(board(uniform_texture(1)), ramp, {.projector_pixels = true})) {
    levels.insert(std::lround(value * 1e3));
  }
  EXPECT_LE(levels.size(), 102U);
}

TEST(Physics, LightFallsWithTheDistanceSquared) {
  Scene near = board(), far = board();
  far.front().pose.translation().z() += 60;
  const Eigen::Vector3d light = projector_centre(scanner());
  const auto at_centre = [&](const Scene& scene) {
    return frame(scene, flat(1), {.fall_off = true})(48, 36);
  };
  const auto squared = [&](const Scene& scene) {
    const double z = scene.front().pose.translation().z();
    return (z * ray_through(scanner().camera, {48, 36}) - light).squaredNorm();
  };
  EXPECT_NEAR(at_centre(near) / at_centre(far), squared(far) / squared(near), 1e-6);
}

TEST(Physics, OtherSurfacesThrowLightIntoShadow) {
  // A wall beside the board, seen edge-on, takes its light and gives some of it back.
  Scene corner = board();
  Eigen::Isometry3d pose = corner.front().pose;
  pose.translate(Eigen::Vector3d(-20, 0, -100));
  pose.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()));
  corner.push_back(Body{.shape = Board{200, 2000}, .pose = pose});
  const Image<double> direct = frame(corner, flat(1), {});
  const Image<double> with_bounces = frame(corner, flat(1), {.bounces = 64});
  int brightened = 0;
  for (std::size_t i = 0; i < direct.pixel_count(); ++i) {
    EXPECT_GE(with_bounces.begin()[i], direct.begin()[i]);
    EXPECT_LE(with_bounces.begin()[i], direct.begin()[i] + 0.8 * 0.8 * 255);
    if (direct.begin()[i] == 0 && with_bounces.begin()[i] > 3) ++brightened;
  }
  EXPECT_GT(brightened, 100);
}

TEST(Physics, AFlatBoardAloneThrowsNoLightOnItself) {
  EXPECT_EQ(mean(frame(board(), flat(1), {})), mean(frame(board(), flat(1), {.bounces = 16})));
}

TEST(Physics, ShotNoiseGrowsWithTheLight) {
  const Physics sensor{.full_well = 5000};
  for (const double shape : {0.2, 0.5, 1.0}) {
    const VirtualScan scan =
        take_scan(scanner(), board(), flat(shape, 12), {.bits = std::nullopt, .physics = sensor});
    double sum = 0, count = 0;
    for (int n = 0; n < 12; n += 2) {
      const Image<double> first = frame_of(scan, n), second = frame_of(scan, n + 1);
      for (int row = 16; row < 56; ++row) {
        for (int column = 24; column < 72; ++column, ++count) {
          sum += std::pow(first(column, row) - second(column, row), 2) / 2;
        }
      }
    }
    const double expected = 0.8 * 255 * shape * 255 / 5000;
    EXPECT_NEAR(sum / count, expected, 0.03 * expected);
  }
}

TEST(Physics, FixedPatternsAreTheSameInAllFrames) {
  const VirtualScan scan = take_scan(
      scanner(), board(), flat(1, 2),
      {.bits = std::nullopt, .physics = {.dark_spread = 0.5, .sensitivity_spread = 0.01}});
  const Image<double> first = frame_of(scan, 0), second = frame_of(scan, 1);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), second.begin()));
  EXPECT_NE(first(10, 10), first(11, 10));
}

TEST(Physics, ASensorForColoursAddsItsNoiseOnce) {
  const Photometry noisy{.noise_variance = 1,
                         .bits = std::nullopt,
                         .physics = {.full_well = 5000,
                                     .read_noise = 10,
                                     .row_noise = 0.3,
                                     .dark_spread = 0.5,
                                     .sensitivity_spread = 0.01}};
  // Without mixture and paint, each channel is a grey frame.
  const VirtualScan grey = take_scan(scanner(), board(), flat(0.5, 3), noisy);
  const VirtualScan coloured = take_colour_scan(scanner(), board(), flat(0.5, 3), noisy, {});
  for (int n = 0; n < 3; ++n) {
    const Image<double> expected = frame_of(grey, n), seen = frame_of(coloured, n);
    EXPECT_TRUE(std::equal(seen.begin(), seen.end(), expected.begin())) << n;
  }
}

TEST(Physics, FlickerIsOfWholeFrames) {
  const Image<double> steady = frame(board(), flat(1, 3), {}, 2);
  const Image<double> flickered = frame(board(), flat(1, 3), {.flicker = 0.05}, 2);
  const double ratio = flickered(40, 40) / steady(40, 40);
  EXPECT_NE(ratio, 1);
  EXPECT_NEAR(ratio, 1, 0.05);
  EXPECT_NEAR(flickered(10, 60) / steady(10, 60), ratio, 1e-12);
}

TEST(Physics, MotionSmearsAndTheShutterRolls) {
  const Texture edge = [](const Eigen::Vector3d& p) { return p.x() < 0 ? 0.2 : 0.8; };
  Scene moving = board(edge);
  moving.front().motion.step = Eigen::Vector3d(60, 0, 0);
  const auto edge_column = [&](const Image<double>& image, int row) {
    int dark = 0;
    for (int column = 0; column < image.width(); ++column) {
      dark += image(column, row) < 0.5 * 255 ? 1 : 0;
    }
    return dark;
  };
  const Image<double> still = frame(moving, flat(1), {});
  const Image<double> rolled = frame(moving, flat(1), {.rolling_shutter = true});
  EXPECT_EQ(edge_column(still, 5), edge_column(still, 66));
  // 60 mm in nine tenths of a frame are some 10 pixels of 96.
  EXPECT_GE(edge_column(rolled, 66), edge_column(rolled, 5) + 5);
  const Image<double> smeared = frame(moving, flat(1), {.motion_blur = true});
  std::set<long> levels;
  for (int column = 0; column < picture.width; ++column) {
    levels.insert(std::lround(smeared(column, 36)));
  }
  EXPECT_EQ(levels.size(), 5U);  // of four looks
}

TEST(Physics, TheTruthOfNoiseIsALine) {
  const PhotometricCalibration truth =
      as_calibrated({.scanner = scanner(),
                     .photometry = {.bits = 8, .physics = {.full_well = 5000, .read_noise = 10}}})
          .photometry;
  const double gain = 255.0 / 5000;
  EXPECT_DOUBLE_EQ(truth.noise_gain, gain);
  EXPECT_NEAR(*truth.noise_variance, gain * 127.5 + gain * gain * 100 + 1.0 / 12, 1e-9);
  EXPECT_NEAR(noise_variance_at(0, *truth.noise_variance, truth.noise_gain),
              std::max(*truth.noise_variance - 127.5 * gain, *truth.noise_variance / 20), 1e-12);
}

}  // namespace slipstream::physics_test
