// Static viewer sources: a cloud file, and frames reconstructed again when settings change.
#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include "frames/pattern_windows.h"
#include "slipstream/cloud_file.h"
#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/viewer.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/temporary_folder.h"
#include "tests/view/made_up_cloud.h"
#include "view/cloud_screen.h"
#include "view/opengl.h"
#include "view/pictures.h"

namespace slipstream::view::still_source_test {

EngineSetup statue_setup() {
  return {.scanner = example_scanner({160, 120}),
          .sequence = {.strategy = DualFrequency{.steps = 4, .high = 16}, .axis = Axis::x}};
}

FrameSet statue_frames(const EngineSetup& setup) {
  return take_scan(setup.scanner, scene_named("statue", setup.scanner), pattern_set(setup.sequence),
                   {.ambient = 5, .noise_variance = 1})
      .frames;
}

int coloured_pixels(const Image<Colour>& picture) {
  return static_cast<int>(std::count_if(picture.begin(), picture.end(), [](const Colour& c) {
    return std::max({c.red, c.green, c.blue}) - std::min({c.red, c.green, c.blue}) > 60;
  }));
}

TEST(StillSource, ShowsACloudFromAFileThatHasNoFrames) {
  const TemporaryFolder folder;
  write_cloud(folder.path() / "wall.ply", cloud_of(wall({160, 120}, 600)));
  const ViewSource source = still_source(read_cloud(folder.path() / "wall.ply").cloud);
  EXPECT_EQ(source.newest().frames.count(), 0);
  EXPECT_TRUE(source.newest().is(source.newest()));
  EXPECT_FALSE(source.change) << "there is nothing to make another cloud of";
  const ViewSettings settings{.colour = PointColour::modulation};  // not stored in the file
  const Image<Colour> bare = render_screen(source, settings, {900, 500}, Surround::nothing);
  const Image<Colour> whole = render_screen(source, settings, {900, 500}, Surround::panel);
  EXPECT_GT(std::count_if(bare.begin(), bare.end(), [](Colour c) { return c.green > 150; }), 5000);
  EXPECT_NE(bare(20, 20), whole(20, 20)) << "the panel lies at the left";
  EXPECT_EQ(bare(897, 60), whole(897, 60)) << "no pictures at the right";
}

TEST(StillSource, ReconstructsItsFramesAnewForAnotherSetup) {
  EngineSetup setup = statue_setup();
  const ViewSource source = still_source({statue_frames(setup)}, setup);
  const ShownCloud first = source.newest();
  EXPECT_GT(point_count(*first.cloud), 3000U);
  EXPECT_EQ(first.frames.count(), 8);
  EXPECT_TRUE(source.newest().is(first));

  setup.settings.minimum_modulation = 60;
  source.change(setup);
  const ShownCloud second = source.newest();
  EXPECT_FALSE(second.is(first));
  EXPECT_LT(point_count(*second.cloud), point_count(*first.cloud));

  setup.settings.nearest = -1;
  EXPECT_THROW(source.change(setup), Error);
  EXPECT_TRUE(source.newest().is(second)) << "what cannot be changed stays as it was";
}

TEST(StillSource, CloudScreenTakesOverWhatOthersChanged) {
  const EngineSetup setup = statue_setup();
  EngineSetup other = setup;
  other.settings.minimum_modulation = 60;
  other.scanner.photometry.response = MeasuredResponse{PowerLaw{2.2}, 2.2};
  ViewSource source = still_source({statue_frames(setup)}, setup);
  source.strategies = {{"one", GrayCode{}}, {"given", setup.sequence.strategy}};
  source.gammas = {{"none", std::nullopt}, {"2.2", other.scanner.photometry.response}};
  std::optional<EngineSetup> changed = other;
  source.changed = [&] { return std::exchange(changed, std::nullopt); };
  const opengl::OffScreenContext context;
  CloudScreen clouds(source, {}, nullptr);
  const opengl::RenderTarget target({320, 240});
  target.bind();
  clouds.draw({.window = {320, 240}, .framebuffer = {320, 240}});
  EXPECT_EQ(clouds.state().setup, other);
  EXPECT_EQ(clouds.state().strategy, 1U);
  EXPECT_EQ(clouds.state().gamma, 1U);
  clouds.state().setup.settings.minimum_modulation = 20;  // the user edits it
  clouds.draw({.window = {320, 240}, .framebuffer = {320, 240}});
  EXPECT_EQ(clouds.state().setup.settings.minimum_modulation, 20);
}

TEST(StillSource, ShowsOtherScansOfARecordingWithTheSetupInUse) {
  EngineSetup setup = statue_setup();
  const ViewSource source = still_source({statue_frames(setup)}, setup, [&](std::size_t number) {
    if (number == 2) throw Error("frames are missing");
    return StillScan{.frames = statue_frames(setup)};
  });

  setup.settings.minimum_modulation = 60;
  source.change(setup);
  const ShownCloud first = source.newest();
  source.show_scan(1);
  const ShownCloud second = source.newest();
  EXPECT_FALSE(second.is(first));
  EXPECT_EQ(point_count(*second.cloud), point_count(*first.cloud));
  EXPECT_THROW(source.show_scan(2), Error);
  EXPECT_TRUE(source.newest().is(second));
}

TEST(StillSource, CloudScreenTakesChangesOfTheSetupBack) {
  const EngineSetup setup = statue_setup();
  const ViewSource source = still_source({statue_frames(setup)}, setup);
  const std::size_t points = point_count(*source.newest().cloud);
  const opengl::OffScreenContext context;
  CloudScreen clouds(source, {}, nullptr);
  const opengl::RenderTarget target({320, 240});
  target.bind();

  for (const double least : {40, 60}) {
    clouds.state().setup.settings.minimum_modulation = least;
    EXPECT_TRUE(clouds.change_setup());
  }
  EXPECT_LT(point_count(*source.newest().cloud), points);

  const double first = setup.settings.minimum_modulation;
  for (const double expected : {40.0, first, first}) {
    clouds.press(GLFW_KEY_Z);
    clouds.draw({.window = {320, 240}, .framebuffer = {320, 240}});
    EXPECT_EQ(clouds.state().setup.settings.minimum_modulation, expected);
  }
  EXPECT_EQ(point_count(*source.newest().cloud), points);
}

TEST(StillSource, KeepsTheFramesOfACloudThatIsHeld) {
  ShownCloud held;
  {
    const EngineSetup setup = statue_setup();
    held = still_source({statue_frames(setup)}, setup).newest();
  }
  EXPECT_EQ(camera_picture(held.frames, 80).size(), (Size{80, 60}));
}

TEST(StillSource, HasThePicturesOfItsFramesBesideTheCloud) {
  const EngineSetup setup = statue_setup();
  const ViewSource source = still_source({statue_frames(setup)}, setup);
  const ViewSettings grey{.colour = PointColour::reflectivity};
  const Image<Colour> bare = render_screen(source, grey, {900, 700}, Surround::nothing);
  const Image<Colour> whole = render_screen(source, grey, {900, 700}, Surround::panel);
  EXPECT_GT(coloured_pixels(whole), coloured_pixels(bare) + 1000) << "phases have hues";
}

TEST(StillSource, ShowsPicturesAloneWhereNoScannerIsKnown) {
  EngineSetup setup = statue_setup();
  const FrameSet frames = statue_frames(setup);
  setup.scanner = without_geometry(frames.size(), {});
  const auto kept = std::make_shared<const Cloud>();
  ViewSource source;
  source.newest = [&] { return ShownCloud{.cloud = kept, .frames = frames}; };
  source.setup = setup;
  const Image<Colour> bare = render_screen(source, {}, {900, 700}, Surround::nothing);
  const Colour unlit = bare(450, 30), lit = bare(100, 350);
  EXPECT_GT(unlit.blue, unlit.red + 30) << "marked as too dark";
  EXPECT_EQ(lit.red, lit.blue);
  EXPECT_GT(lit.red, 20);
}

TEST(StillSource, GreyHistogramCountsFromDarkToBright) {
  Image<std::uint8_t> dark({70, 70}, 0), bright({70, 70}, 255);
  const GreyHistogram histogram = grey_histogram(Frames<std::uint8_t>{dark, bright});
  EXPECT_EQ(histogram.front(), 1);
  EXPECT_EQ(histogram.back(), 1);
  EXPECT_EQ(*std::max_element(histogram.begin() + 1, histogram.end() - 1), 0);
}

TEST(StillSource, CameraPictureShowsFramesOfAnyDepthAndWhereTheyAreSaturated) {
  const auto picture_of = [](auto top, const auto& views_of) {
    using Pixel = decltype(top);
    Image<Pixel> dark({4, 4}), bright({4, 4});
    bright(1, 2) = top;
    return camera_picture(views_of(Frames<Pixel>{dark, bright}), 4);
  };
  const Colour red{235, 40, 40}, black{0, 0, 0};
  const Image<Colour> of_8 = picture_of(std::uint8_t{255}, [](auto v) { return FrameViews(v); });
  const Image<Colour> of_12 =
      picture_of(std::uint16_t{4095}, [](auto v) { return FrameViews(v, 12); });
  const Image<Colour> unquantised = picture_of(255.0, [](auto v) { return FrameViews(v); });
  EXPECT_EQ(of_8(1, 2), red);
  EXPECT_EQ(of_12(1, 2), red);
  EXPECT_EQ(unquantised(1, 2), black);
  EXPECT_EQ(of_8(0, 0), black);
  EXPECT_TRUE(camera_picture({}, 4).empty());
}

}  // namespace slipstream::view::still_source_test
