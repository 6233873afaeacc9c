// The viewer on synthetic clouds, off-screen and in a window. Skipped without OpenGL, or without a
// desktop and Xvfb.
#include "slipstream/viewer.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "slipstream/error.h"
#include "slipstream/image.h"
#include "tests/io/temporary_folder.h"
#include "tests/view/desktop.h"
#include "tests/view/made_up_cloud.h"
#include "tests/view/off_screen.h"
#include "view/cloud_screen.h"
#include "view/gui.h"
#include "view/opengl.h"
#include "view/panel.h"

namespace slipstream::view::viewer_test {

/// A plate that approaches with each call of newest().
class MovingPlate {
 public:
  ShownCloud newest() {
    const MadeUpCloud plate = wall({64, 48}, 600 - static_cast<float>(given_++ % 100));
    return {.cloud = std::make_shared<const Cloud>(cloud_of(plate))};
  }
  [[nodiscard]] int given() const { return given_; }

 private:
  int given_ = 0;
};

ViewSource source_of(MovingPlate& plate, int& shown) {
  ViewSource source;
  source.newest = [&plate] { return plate.newest(); };
  source.shown = [&shown](const ShownCloud&) { ++shown; };
  source.statistics = [] {
    LiveStatistics statistics;
    statistics.frames.captured = 123;
    statistics.stages.push_back({.name = "capture", .done = 123, .rate = 120, .latency = {}});
    return statistics;
  };
  return source;
}

int bright_pixels(const Image<Colour>& picture) {
  return static_cast<int>(std::count_if(picture.begin(), picture.end(), [](const Colour& c) {
    return c.red > 150 && c.red == c.green && c.green == c.blue;
  }));
}

TEST(Viewer, RenderScreenHasTheCloudWithAndWithoutPanel) {
  MovingPlate plate;
  int shown = 0;
  const ViewSource source = source_of(plate, shown);
  Image<Colour> bare, whole;
  bare =
      render_screen(source, {.colour = PointColour::reflectivity}, {480, 360}, Surround::nothing);
  whole = render_screen(source, {.colour = PointColour::reflectivity}, {480, 360}, Surround::panel);
  EXPECT_GT(bright_pixels(bare), 480 * 360 / 20);
  EXPECT_GT(bright_pixels(whole), 500) << "a smaller cloud beside the panel";
  EXPECT_NE(bare(20, 20), whole(20, 20)) << "the panel lies at the left";
  EXPECT_EQ(shown, 0) << "nothing was on a screen";
}

class ViewerCloudScreen : public OffScreen {
 protected:
  Image<Colour> drawn(CloudScreen& clouds, const Screen& screen) {
    const opengl::RenderTarget target(screen.framebuffer);
    target.bind();
    for (int pass = 0; pass < 3; ++pass) clouds.draw(screen);
    return opengl::read_pixels(screen.framebuffer);
  }
  static Screen screen(Size size) { return {.window = size, .framebuffer = size}; }

  MovingPlate plate_;
  int shown_ = 0;
  ViewSource source_ = source_of(plate_, shown_);
};

TEST_F(ViewerCloudScreen, IsDrawnInWindowsOfAnySize) {
  CloudScreen clouds(source_, {.colour = PointColour::reflectivity}, nullptr);
  EXPECT_TRUE(clouds.take_newest());
  for (const Size size : {Size{640, 480}, Size{1280, 800}, Size{200, 900}, Size{1, 1}}) {
    EXPECT_EQ(drawn(clouds, screen(size)).size(), size);
  }
  clouds.state().shown = false;
  EXPECT_GT(bright_pixels(drawn(clouds, screen({640, 480}))), 2000);
}

TEST_F(ViewerCloudScreen, IsAsLargeOnHiDpi) {
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  // Scaled by the window itself, or by the desktop.
  const Screen by_window{.window = {1280, 960}, .framebuffer = {1280, 960}, .content_scale = 2};
  const Screen by_desktop{.window = {640, 480}, .framebuffer = {1280, 960}, .content_scale = 2};
  EXPECT_FLOAT_EQ(by_window.unit(), 2);
  EXPECT_FLOAT_EQ(by_desktop.unit(), 1);
  EXPECT_FLOAT_EQ(by_desktop.pixel_ratio(), 2);
  const Image<Colour> first = drawn(clouds, by_window), second = drawn(clouds, by_desktop);
  ASSERT_EQ(first.size(), second.size());
  int different = 0;
  for (std::size_t i = 0; i < first.pixel_count(); ++i) {
    different += std::abs(first.begin()[i].green - second.begin()[i].green) > 40 ? 1 : 0;
  }
  EXPECT_LT(different, 1280 * 960 / 50);
}

TEST_F(ViewerCloudScreen, TextGrowsWithLargeWindows) {
  EXPECT_FLOAT_EQ(screen({1280, 800}).unit(), 1);
  EXPECT_GT(screen({3840, 2160}).unit(), 2);
  const Screen by_desktop{.window = {1920, 1080}, .framebuffer = {3840, 2160}, .content_scale = 2};
  EXPECT_NEAR(by_desktop.unit() * by_desktop.pixel_ratio(), screen({3840, 2160}).unit(), 0.05);
}

TEST_F(ViewerCloudScreen, LosesNoKeyBetweenTwoPictures) {
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  for (const int key : {GLFW_KEY_3, GLFW_KEY_SPACE, GLFW_KEY_6, GLFW_KEY_M, GLFW_KEY_TAB,
                        GLFW_KEY_ESCAPE, GLFW_KEY_ENTER}) {
    clouds.press(key);
  }
  drawn(clouds, screen({640, 480}));
  const PanelState& state = clouds.state();
  EXPECT_EQ(state.view.colour, PointColour::modulation);
  EXPECT_TRUE(state.paused);
  EXPECT_GT(state.view.camera.elevation, 1.5F) << "from above";
  EXPECT_TRUE(state.measures);
  EXPECT_FALSE(state.shown);
  EXPECT_TRUE(clouds.closed());
  clouds.press(GLFW_KEY_SPACE);
  clouds.press(GLFW_KEY_SPACE);
  drawn(clouds, screen({640, 480}));
  EXPECT_TRUE(state.paused) << "twice is not once";
}

TEST_F(ViewerCloudScreen, ClosesTheListOfKeysByEscBeforeItAsksToCloseTheWindow) {
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  PanelState& state = clouds.state();
  state.shows_keys = true;
  for (const bool closing : {false, true}) {
    clouds.press(GLFW_KEY_ESCAPE);
    drawn(clouds, screen({640, 480}));
    EXPECT_FALSE(state.shows_keys);
    EXPECT_EQ(state.closing, closing);
  }
}

TEST_F(ViewerCloudScreen, ShowsThreeViewsUntilOneIsChosen) {
  CloudScreen clouds(source_, {.three_views = true}, nullptr);
  clouds.take_newest();
  drawn(clouds, screen({640, 480}));
  EXPECT_TRUE(clouds.state().view.three_views) << "as requested";

  const auto after = [&](int key) {
    clouds.press(key);
    drawn(clouds, screen({640, 480}));
    return clouds.state().view.three_views;
  };
  EXPECT_FALSE(after(GLFW_KEY_5)) << "the side alone";
  EXPECT_TRUE(after(GLFW_KEY_7)) << "all again";
  EXPECT_FALSE(after(GLFW_KEY_7)) << "and back";
}

TEST_F(ViewerCloudScreen, SaysWhyThereAreNoPoints) {
  Cloud dark({64, 48});
  std::fill(dark.validity.begin(), dark.validity.end(), Validity::too_dark);
  const auto shared = std::make_shared<const Cloud>(dark);
  source_.newest = [&] { return ShownCloud{.cloud = shared}; };
  CloudScreen clouds(source_, {}, nullptr);
  const Image<Colour> waiting = drawn(clouds, screen({900, 500}));
  clouds.take_newest();
  const Image<Colour> empty = drawn(clouds, screen({900, 500}));
  const std::string why = why_no_points(clouds.state());
  EXPECT_NE(why.find("100.0 % of the pixels: too dark"), std::string::npos) << why;
  EXPECT_NE(why.find("expose longer"), std::string::npos) << why;
  EXPECT_GT(bright_pixels(waiting), 0) << "says what it waits for";
  EXPECT_FALSE(std::equal(waiting.begin(), waiting.end(), empty.begin()));
}

TEST_F(ViewerCloudScreen, HasAScaleOfDepth) {
  CloudScreen clouds(source_, {.colour = PointColour::depth}, nullptr);
  clouds.take_newest();
  for (const bool with_panel : {true, false}) {
    clouds.state().shown = with_panel;
    const Image<Colour> image = drawn(clouds, screen({900, 500}));
    for (const Colour& end : {depth_colours().front(), depth_colours().back()}) {
      EXPECT_GT(std::count(image.begin() + 900 * 200, image.end(), end), 10) << with_panel;
    }
  }
}

TEST_F(ViewerCloudScreen, StepsThroughARecordingAndPlaysIt) {
  std::vector<std::size_t> chosen;
  source_.statistics = nullptr;
  source_.scans = 3;
  source_.show_scan = [&](std::size_t number) {
    if (number == 2) throw Error("frames are missing");
    chosen.push_back(number);
  };

  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  const auto press = [&](int key) {
    clouds.press(key);
    drawn(clouds, screen({900, 500}));
    return clouds.state().scan;
  };
  EXPECT_EQ(press(GLFW_KEY_RIGHT), 1U);
  EXPECT_EQ(press(GLFW_KEY_RIGHT), 2U);
  EXPECT_EQ(clouds.state().message, "frames are missing");
  EXPECT_EQ(press(GLFW_KEY_RIGHT), 0U) << "the first follows the last";
  EXPECT_EQ(chosen, (std::vector<std::size_t>{1, 0}));

  press(GLFW_KEY_SPACE);
  EXPECT_TRUE(clouds.take_newest());
  EXPECT_EQ(clouds.state().scan, 1U) << "plays";
  EXPECT_EQ(press(GLFW_KEY_LEFT), 0U);
  EXPECT_FALSE(clouds.state().plays) << "a step ends it";
}

TEST_F(ViewerCloudScreen, WritesTheCloudShownInTheFormatOfTheEnding) {
  const TemporaryFolder folder;
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  for (const char* const name : {"cloud.ply", "surface.stl"}) {
    const std::string path = (folder.path() / name).string();
    clouds.take_file({FileQuestion::save, path});
    EXPECT_EQ(clouds.state().message, "saved: " + path);
    EXPECT_EQ(point_count(read_cloud(path).cloud), 64U * 48) << name;
  }

  clouds.take_file({FileQuestion::save, (folder.path() / "cloud.las").string()});
  EXPECT_NE(clouds.state().message.find(".las"), std::string::npos) << clouds.state().message;
}

TEST_F(ViewerCloudScreen, OpensAnotherFileOrSaysWhyNot) {
  source_.open = [](const std::string& path) {
    if (path == "missing") throw Error("missing: there is none");
    ViewSource other;
    other.title = path;
    return other;
  };
  CloudScreen clouds(source_, {}, nullptr);
  clouds.open("missing");
  EXPECT_FALSE(clouds.take_next());
  EXPECT_EQ(clouds.state().message, "missing: there is none");
  clouds.open("other");
  const auto next = clouds.take_next();
  ASSERT_TRUE(next);
  const ViewSource opened = next();
  EXPECT_EQ(opened.title, "other");
  EXPECT_TRUE(opened.open) << "and another from there";
  EXPECT_FALSE(clouds.take_next());
}

TEST_F(ViewerCloudScreen, WordsItsMessagesAsTheSourceWishes) {
  source_.open = [](const std::string&) -> std::optional<ViewSource> {
    throw Error("lower `minimum_modulation`");
  };
  source_.wording = [](std::string_view text) { return "so: " + std::string(text); };
  CloudScreen clouds(source_, {}, nullptr);
  clouds.open("missing");
  EXPECT_EQ(clouds.state().message, "so: lower `minimum_modulation`");
}

class ExposedCamera : public CameraControls {
 public:
  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const override {
    if (which != CameraControl::exposure) return std::nullopt;
    return ControlValue{.value = ms, .least = 1, .most = 20};
  }
  void set_control(CameraControl, double value) override { ms = value; }

  double ms = 2;
};

TEST_F(ViewerCloudScreen, SetsTheBestExposureOrSaysWhyNot) {
  ExposedCamera camera;
  const auto pressed = [&] {
    CloudScreen clouds(source_, {}, nullptr);
    clouds.press(GLFW_KEY_E);
    drawn(clouds, screen({640, 480}));
    clouds.take_newest();
    return clouds.state().message;
  };
  source_.best_exposure = [](const ShownCloud&, double) { return 50.0; };
  EXPECT_EQ(pressed(), "") << "without a camera";
  source_.camera = &camera;
  EXPECT_EQ(pressed(), "");
  EXPECT_EQ(camera.ms, 20) << "within its range";
  source_.best_exposure = [](const ShownCloud&, double) -> double { throw Error("all dark"); };
  EXPECT_EQ(pressed(), "all dark");
  EXPECT_EQ(camera.ms, 20);
}

TEST_F(ViewerCloudScreen, TellsOnceThatACloudIsShown) {
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  clouds.tell_shown();
  clouds.tell_shown();
  EXPECT_EQ(shown_, 1);
}

TEST_F(ViewerCloudScreen, TakesNoCloudWhilePaused) {
  CloudScreen clouds(source_, {}, nullptr);
  clouds.take_newest();
  const int given = plate_.given();
  clouds.state().paused = true;
  EXPECT_FALSE(clouds.take_newest());
  EXPECT_EQ(plate_.given(), given);
  clouds.state().paused = false;
  EXPECT_TRUE(clouds.take_newest());
}

TEST(Viewer, ShowsMovingCloudsIsResizedAndClosesWhileTheyStream) {
  const Desktop desktop;
  MovingPlate plate;
  int shown = 0, asked = 0;
  const ViewSource source = source_of(plate, shown);
  ViewerSettings settings;
  settings.size = {640, 480};
  settings.keep_last = true;
  settings.view.colour = PointColour::reflectivity;
  settings.ends = [&] {
    GLFWwindow* const window = glfwGetCurrentContext();
    if (++asked == 5) glfwSetWindowSize(window, 800, 500);
    return shown >= 12 || asked > 5000;
  };
  const std::optional<Image<Colour>> last = run_viewer(source, settings);
  EXPECT_GE(shown, 12);
  EXPECT_GE(plate.given(), shown);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->size(), (Size{800, 500}));
  EXPECT_GT(bright_pixels(*last), 2000);
}

/// As if the user pressed it in the present window.
void press(int key) {
  GLFWwindow* const window = glfwGetCurrentContext();
  const GLFWkeyfun callback = glfwSetKeyCallback(window, nullptr);
  glfwSetKeyCallback(window, callback);
  callback(window, key, 0, GLFW_PRESS, 0);
}

TEST(Viewer, FreesASourceBeforeItMakesAnother) {
  const Desktop desktop;
  MovingPlate plate;
  int shown = 0, asked = 0;
  auto camera = std::make_shared<int>(0);
  const std::weak_ptr<int> held = camera;
  std::optional<bool> freed;

  ViewSource source = source_of(plate, shown);
  source.newest = [&plate, camera = std::move(camera)] { return plate.newest(); };
  source.steps = std::make_shared<ViewSteps>();
  source.steps->buttons = {{.name = "another", .key = GLFW_KEY_N, .begin = [&] {
                              freed = held.expired();
                              return source_of(plate, shown);
                            }}};

  const auto ends = [&] {
    if (++asked == 5) press(GLFW_KEY_N);
    return freed || asked > 5000;
  };
  run_viewer(std::move(source), {.size = {640, 480}, .ends = ends});
  EXPECT_EQ(freed, true);
}

}  // namespace slipstream::view::viewer_test
