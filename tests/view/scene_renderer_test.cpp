// Renders off-screen and checks pixels. Skipped without OpenGL.
#include "view/scene_renderer.h"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/surface.h"
#include "tests/view/made_up_cloud.h"
#include "tests/view/off_screen.h"
#include "view/lines.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"

namespace slipstream::view::scene_renderer_test {

constexpr Size picture{320, 240};

/// Points only, viewed from the scanner's camera, 600 mm away.
ViewSettings bare() {
  return {.point_size = 1,
          .shaded = false,
          .reflection = false,
          .axes = false,
          .grid = false,
          .camera = {.target = in_display_frame({0, 0, 600}), .distance = 600}};
}

class SceneRendererOffScreen : public OffScreen {
 protected:
  static Image<Colour> drawn(const MadeUpCloud& cloud, const ViewSettings& settings,
                             const CloudExtent& extent, Size size = picture,
                             const Image<float>* light = nullptr) {
    SceneRenderer scene;
    scene.set_extent(extent);
    PointImages images = cloud.images();
    images.shading = light;
    scene.set_cloud(images, nullptr, settings.colour);
    const opengl::RenderTarget target(size);
    target.bind();
    scene.draw(settings, 0, {.size = size});
    return opengl::read_pixels(size);
  }

  static Colour background(const ViewSettings& settings) {
    return drawn(MadeUpCloud({4, 4}), settings, {})(0, 0);
  }
};

int brightness(const Colour& colour) {
  return colour.red + colour.green + colour.blue;
}

TEST_F(SceneRendererOffScreen, DrawsAPointAtThePixelWhereItIs) {
  MadeUpCloud cloud({2, 2});
  cloud.put(0, 0, 40, -30, 600, 200);
  const ViewSettings settings = bare();
  const Image<Colour> image = drawn(cloud, settings, {.box = {{-50, -50, 550}, {50, 50, 650}}});
  const auto pixel =
      pixel_of(clip_matrix(settings.camera, picture) * glm::vec4(40, -30, 600, 1), picture);
  const int column = static_cast<int>(std::lround(pixel->x));
  const int row = static_cast<int>(std::lround(pixel->y));
  EXPECT_LT(row, 120) << "Y is down in the scanner's frame";
  int lit = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (brightness(image(x, y)) < 300) continue;
      ++lit;
      EXPECT_LE(std::abs(x - column), 1);
      EXPECT_LE(std::abs(y - row), 1);
    }
  }
  EXPECT_GE(lit, 1);
}

TEST(SceneRenderer, FloorGridEndsFarFromTheOrigin) {
  const glm::vec3 far(1e9F, 0, 1e9F);
  EXPECT_LE(floor_grid({far, far + glm::vec3(0, 1, 0)}, 0).size(), 128U);
  // Every 5 mm from -20 to 20, and from 80 to 120.
  EXPECT_EQ(floor_grid({{-10, -10, 90}, {10, 10, 110}}, 0).size(), 18U);
}

TEST_F(SceneRendererOffScreen, DrawsNothingForPixelsWithoutAPoint) {
  const ViewSettings settings = bare();
  const Colour nothing = background(settings);
  for (const bool organised : {true, false}) {
    MadeUpCloud cloud(organised ? Size{20, 20} : Size{400, 1});
    std::fill(cloud.intensity.begin(), cloud.intensity.end(), 255.0F);
    const Image<Colour> image = drawn(cloud, settings, {});
    EXPECT_TRUE(std::all_of(image.begin(), image.end(), [&](Colour c) { return c == nothing; }));
  }
}

TEST_F(SceneRendererOffScreen, ShowsBrightSurfacesBrightAndOnTheirSide) {
  const MadeUpCloud cloud = wall({160, 120}, 600);
  for (const Size size : {picture, Size{400, 700}, Size{801, 333}}) {
    ViewSettings settings = bare();
    settings.colour = PointColour::reflectivity;
    const CloudExtent extent = extent_of(cloud.images());
    settings.camera = fitted(settings.camera, extent.box, size);
    settings.point_size = 2;
    const Image<Colour> image = drawn(cloud, settings, extent, size);
    ASSERT_EQ(image.size(), size);
    const int middle = size.height / 2, quarter = size.height / 8;
    EXPECT_GT(brightness(image(size.width / 2 - quarter, middle)), 600);
    EXPECT_LT(brightness(image(size.width / 2 + quarter, middle)), 420);
    EXPECT_GT(brightness(image(size.width / 2 + quarter, middle)), 150);
  }
}

TEST_F(SceneRendererOffScreen, ColoursDepthFromRedToBlue) {
  MadeUpCloud cloud = wall({160, 120}, 600);
  for (int row = 0; row < 120; ++row) {
    for (int column = 80; column < 160; ++column) cloud.z(column, row) = 700;
  }
  ViewSettings settings = bare();
  settings.colour = PointColour::depth;
  settings.point_size = 2;
  const Image<Colour> image = drawn(cloud, settings, extent_of(cloud.images()));
  const Colour near_colour = image(120, 120), far_colour = image(200, 120);
  EXPECT_GT(near_colour.red, near_colour.blue + 50);
  EXPECT_GT(far_colour.blue, far_colour.red + 50);
}

TEST_F(SceneRendererOffScreen, ShowsTheCamerasColoursAsTheyAre) {
  const MadeUpCloud cloud = wall({160, 120}, 600);
  const Image<Colour> colours({160, 120}, Colour{200, 90, 13});
  ViewSettings settings = bare();
  settings.colour = PointColour::camera;
  settings.point_size = 2;

  SceneRenderer scene;
  scene.set_extent(extent_of(cloud.images()));
  PointImages images = cloud.images();
  images.colour = &colours;
  scene.set_cloud(images, nullptr, settings.colour);
  const opengl::RenderTarget target(picture);
  target.bind();
  scene.draw(settings, 0, {.size = picture});
  EXPECT_EQ(opengl::read_pixels(picture)(160, 120), (Colour{200, 90, 13}));

  // Without colours, grey.
  scene.set_cloud(cloud.images(), nullptr, settings.colour);
  scene.draw(settings, 0, {.size = picture});
  const Colour grey = opengl::read_pixels(picture)(160, 120);
  EXPECT_EQ(grey.red, grey.blue);
}

TEST_F(SceneRendererOffScreen, ColoursDepthWhereNoBrightnessIsKnown) {
  MadeUpCloud cloud = wall({160, 120}, 600);
  std::fill(cloud.intensity.begin(), cloud.intensity.end(), 0.0F);
  cloud.z(0, 0) = 700;
  ViewSettings settings = bare();
  settings.point_size = 2;
  const Colour colour = drawn(cloud, settings, extent_of(cloud.images()))(120, 120);
  settings.colour = PointColour::depth;
  EXPECT_EQ(colour, drawn(cloud, settings, extent_of(cloud.images()))(120, 120));
  EXPECT_GT(brightness(colour), 200);
}

TEST_F(SceneRendererOffScreen, ReflectsTheCloudInTheFloorDimmed) {
  // A small bright plate well above the floor.
  MadeUpCloud cloud = wall({60, 60}, 600);
  for (float& x : cloud.x) x *= 0.2F;
  for (float& y : cloud.y) y *= 0.2F;
  std::fill(cloud.intensity.begin(), cloud.intensity.end(), 200.0F);
  CloudExtent extent = extent_of(cloud.images());
  ViewSettings settings = bare();
  settings.camera.elevation = 0.1F;
  settings.point_size = 3;
  const Image<Colour> without = drawn(cloud, settings, extent);
  settings.reflection = true;
  const Image<Colour> with = drawn(cloud, settings, extent);
  const float floor = floor_height(extent);
  const auto mirrored =
      pixel_of(clip_matrix(settings.camera, picture) * glm::vec4(0, 2 * floor, 600, 1), picture);
  const int column = static_cast<int>(mirrored->x), row = static_cast<int>(mirrored->y);
  EXPECT_GT(row, 130) << "the image lies under the thing";
  EXPECT_EQ(without(column, row), background(settings));
  EXPECT_GT(brightness(with(column, row)), brightness(without(column, row)) + 60);
  EXPECT_LT(brightness(with(column, row)), brightness(with(160, 120)) / 2);
  EXPECT_EQ(with(160, 120), without(160, 120));
}

TEST_F(SceneRendererOffScreen, ReflectsACloudAboveTheCamera) {
  // Y is down: all of the plate, and the floor below it, have negative Y.
  MadeUpCloud cloud = wall({60, 60}, 600);
  for (float& x : cloud.x) x *= 0.2F;
  for (float& y : cloud.y) y = 0.2F * y - 200;
  std::fill(cloud.intensity.begin(), cloud.intensity.end(), 200.0F);
  const CloudExtent extent = extent_of(cloud.images());
  ASSERT_LT(floor_height(extent), 0);

  ViewSettings settings = bare();
  settings.camera.target = in_display_frame({0, -200, 600});
  settings.camera.elevation = 0.1F;
  settings.point_size = 3;
  settings.reflection = true;
  const Image<Colour> image = drawn(cloud, settings, extent);

  const glm::vec4 reflected(0, 2 * floor_height(extent) + 200, 600, 1);
  const auto pixel = pixel_of(clip_matrix(settings.camera, picture) * reflected, picture);
  ASSERT_TRUE(pixel.has_value());
  const Colour colour = image(static_cast<int>(pixel->x), static_cast<int>(pixel->y));
  EXPECT_GT(brightness(colour), brightness(background(settings)) + 60);
}

TEST_F(SceneRendererOffScreen, LightensSlopesTowardsTheLight) {
  ViewSettings settings = bare();
  settings.shaded = true;
  settings.point_size = 2;
  const auto brightness_of_slope = [&](float slope) {
    MadeUpCloud cloud = wall({160, 120}, 600);
    std::fill(cloud.intensity.begin(), cloud.intensity.end(), 200.0F);
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      cloud.z.begin()[i] += slope * cloud.x.begin()[i];
    }
    const Image<float> light = shading(cloud_of(cloud));
    return brightness(drawn(cloud, settings, extent_of(cloud.images()), picture, &light)(160, 120));
  };
  // The light is behind the viewer on the left: a wall with its left end nearer faces away from it.
  EXPECT_LT(brightness_of_slope(0.5F), brightness_of_slope(0) - 60);
  EXPECT_GT(brightness_of_slope(-0.4F), brightness_of_slope(0) + 20);
}

TEST_F(SceneRendererOffScreen, DarkensASurfaceBesideANearerOne) {
  MadeUpCloud cloud = wall({160, 120}, 600);
  std::fill(cloud.intensity.begin(), cloud.intensity.end(), 200.0F);
  for (int row = 0; row < 120; ++row) {
    for (int column = 80; column < 160; ++column) cloud.z(column, row) = 650;
  }

  ViewSettings settings = bare();
  settings.colour = PointColour::reflectivity;
  settings.point_size = 3;
  const CloudExtent extent = extent_of(cloud.images());
  const Image<Colour> plain = drawn(cloud, settings, extent);
  settings.shaded = true;
  const Image<Colour> shaded = drawn(cloud, settings, extent);

  // The farther one begins right of the middle.
  int darkest = brightness(plain(164, 120));
  for (int column = 160; column < 168; ++column) {
    darkest = std::min(darkest, brightness(shaded(column, 120)));
  }
  EXPECT_LT(darkest, brightness(plain(164, 120)) / 2);
  EXPECT_EQ(shaded(200, 120), plain(200, 120)) << "a plane keeps its brightness";
  EXPECT_EQ(shaded(140, 120), plain(140, 120)) << "and so does the nearer one";
  EXPECT_EQ(shaded(5, 5), plain(5, 5)) << "and the background";
}

TEST_F(SceneRendererOffScreen, DrawsThreeViewsSideBySide) {
  const MadeUpCloud cloud = wall({160, 120}, 600);
  ViewSettings settings = bare();
  settings.colour = PointColour::depth;
  settings.three_views = true;
  const Size size{600, 200};
  const Image<Colour> image = drawn(cloud, settings, extent_of(cloud.images()), size);

  // From the side and from above, a wall is a line.
  const Colour nothing = background(bare());
  std::array<int, 3> lit{};
  for_each_pixel_in_order(size, [&](int column, int row) {
    if (!(image(column, row) == nothing)) ++lit[3 * column / size.width];
  });
  EXPECT_GT(lit[0], 5000);
  for (const int view : {1, 2}) {
    EXPECT_GT(lit[view], 50) << view;
    EXPECT_LT(lit[view], lit[0] / 4) << view;
  }
}

TEST_F(SceneRendererOffScreen, RefusesAPictureThatCannotBe) {
  EXPECT_THROW(opengl::RenderTarget({0, 100}), Error);
  EXPECT_THROW(opengl::RenderTarget({1 << 20, 10}), Error);
}

}  // namespace slipstream::view::scene_renderer_test
