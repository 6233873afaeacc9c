// What a camera's exposure and processing do to its pictures.
#include "simulate/camera_picture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/virtual_world.h"

namespace slipstream::camera_picture_test {

constexpr Size size{64, 48};

/// Levels by column.
Image<double> picture_of(const std::function<double(int column)>& level) {
  Image<double> picture(size);
  for_each_pixel_in_order(size, [&](int column, int row) { picture(column, row) = level(column); });
  return picture;
}

/// The level of frame n at a column of the middle row.
double level_of(const FrameSet& frames, int column, std::size_t n = 0) {
  double level = 0;
  frames.visit(
      [&](const auto& views) { level = static_cast<double>(views[n](column, size.height / 2)); });
  return level;
}

FrameSet pictures(std::vector<Image<double>> light, const Physics& physics,
                  std::size_t channels = 1) {
  return camera_pictures(std::move(light), 0, {.physics = physics}, channels);
}

TEST(CameraPicture, FollowsTheToneCurve) {
  const Image<double> ramp = picture_of([](int column) { return 4.0 * column; });
  const FrameSet frames = pictures({ramp}, {.tone = PowerLaw{0.5}});
  const FrameSet srgb = pictures({ramp}, photometry_named("ideal,tone-curve").physics);

  for (int column = 0; column < size.width; ++column) {
    const double signal = 4.0 * column / 255;
    EXPECT_NEAR(level_of(frames, column), 255 * std::sqrt(signal), 0.51) << column;

    const double encoded =
        signal <= 0.0031308 ? 12.92 * signal : 1.055 * std::pow(signal, 1 / 2.4) - 0.055;
    EXPECT_NEAR(level_of(srgb, column), 255 * encoded, 0.6) << column;
  }
}

TEST(CameraPicture, OvershootsAtSharpenedEdges) {
  const int edge = size.width / 2;
  const Image<double> step = picture_of([=](int column) { return column < edge ? 60.0 : 180.0; });
  const FrameSet frames = pictures({step}, {.sharpening = 0.5});

  EXPECT_LT(level_of(frames, edge - 1), 50);
  EXPECT_GT(level_of(frames, edge), 190);
  EXPECT_EQ(level_of(frames, 5), 60);
  EXPECT_EQ(level_of(frames, size.width - 5), 180);
}

TEST(CameraPicture, IsExposedByAShareOfTheStops) {
  const Image<double> dark = picture_of([](int) { return 16; });
  const Image<double> bright = picture_of([](int) { return 144; });

  const FrameSet grey = pictures({dark, bright}, {.auto_exposure = 0.5});
  EXPECT_EQ(level_of(grey, 0, 0), 32);
  EXPECT_EQ(level_of(grey, 0, 1), 96);

  // The channels of a picture have one gain.
  const FrameSet colour = pictures({dark, bright, bright}, {.auto_exposure = 0.5}, 3);
  EXPECT_NEAR(level_of(colour, 0, 1) / level_of(colour, 0, 0), 9, 0.5);
}

TEST(CameraPicture, KeepsFineDetailOfGreyAloneInAJpeg) {
  const Image<double> fine = picture_of([](int column) { return column % 2 == 0 ? 80.0 : 160.0; });
  const Image<double> even = picture_of([](int) { return 120; });
  const Physics jpeg{.jpeg_quality = 95};

  const auto contrast = [](const FrameSet& frames) {
    return std::abs(level_of(frames, 30) - level_of(frames, 31));
  };
  EXPECT_NEAR(contrast(pictures({fine}, jpeg)), 80, 16);
  EXPECT_NEAR(contrast(pictures({fine, fine, fine}, jpeg, 3)), 80, 16);

  // In red alone it is mostly colour, which has half of the resolution.
  EXPECT_LT(contrast(pictures({fine, even, even}, jpeg, 3)), 50);
}

TEST(CameraPicture, IsAJpegOf8BitsOnly) {
  const Physics jpeg{.jpeg_quality = 90};
  EXPECT_NO_THROW(require_valid(Photometry{.physics = jpeg}));
  EXPECT_THROW(require_valid(Photometry{.bits = 12, .physics = jpeg}), Error);
  EXPECT_THROW(require_valid(Photometry{.physics = {.jpeg_quality = 101}}), Error);
}

TEST(CameraPicture, HasUnknownNoiseOnceProcessed) {
  const auto known = [](const char* world) {
    return as_calibrated(virtual_world({.world = world})).photometry;
  };
  EXPECT_TRUE(known("bench,auto-exposure").noise_variance);
  for (const char* world : {"bench,tone-curve", "bench,sharpening", "bench,jpeg"}) {
    EXPECT_FALSE(known(world).noise_variance) << world;
  }

  // An unlit wall of ambient light 5 is far brighter in sRGB.
  EXPECT_NEAR(known("bench,tone-curve").ambient.value(), 38, 1);
}

}  // namespace slipstream::camera_picture_test
