// Names of cameras and sources. virtual_gige_camera_test.cpp tests that names of connected cameras
// open them.
#include "slipstream/named_source.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "frames/colour_channels.h"
#include "simulate/virtual_files.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::named_source_test {
using namespace std::chrono_literals;

VirtualWorld some_world() {
  VirtualWorld world{.scanner = example_scanner({48, 36})};
  world.scene = scene_named("sphere", world.scanner);
  world.photometry = {.ambient = 5, .noise_variance = 1};
  return world;
}

const Strategy four_steps = PhaseMeasuring{.steps = 4};

TEST(NamedSource, OpenSourceVirtualKnowsItsScannerAndWhatIsShown) {
  SourceRequest request{.rate = 0, .world = some_world()};
  request.sequence.strategy = "pmp";
  request.sequence.settings = {{"steps", "4"}};
  NamedSource source = open_source(request);
  EXPECT_EQ(source.sequence.strategy, four_steps);
  EXPECT_EQ(source.scanner, as_calibrated(some_world()));
  EXPECT_EQ(source.scanner->photometry.ambient, 5);
  EXPECT_EQ(source.frames->format(), (FrameFormat{{48, 36}, 8}));
  source.frames->start();
  Frame frame(source.frames->format());
  EXPECT_EQ(source.frames->next(frame, 1000ms), Arrival::frame);
  expect_error([] { (void)open_source({.source = "virtual"}); }, {"virtual"});
}

TEST(NamedSource, OpenSourceReplayedFolderSaysWhatItShowsUnlessToldOtherwise) {
  const TemporaryFolder folder;
  const VirtualWorld world = some_world();
  const Sequence sequence{.strategy = four_steps, .projector = world.scanner.projector.size};
  save_scan(folder.path(), take_scan(world.scanner, world.scene, pattern_set(sequence)).frames,
            sequence, {.scanner = world.scanner});
  SourceRequest request{.source = "replay:" + folder.path().string()};
  EXPECT_EQ(open_source(request).sequence, sequence);
  EXPECT_EQ(open_source(request).scanner, world.scanner);

  Scanner other = world.scanner;
  other.translation.x() += 1;
  write_scanner(folder.path() / "other.yaml", other);
  request.scanner = folder.path() / "other.yaml";
  request.sequence.axes = "y";
  EXPECT_EQ(open_source(request).scanner, other);
  EXPECT_EQ(open_source(request).sequence.axis, Axis::y);
}

TEST(NamedSource, OpenSourceTakesARecordingInColourApartUnlessItIsToBeKept) {
  const TemporaryFolder folder;
  VirtualWorld world = some_world();
  world.scanner.photometry.colour_mixture = usual_mixture;
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 3},
                          .projector = world.scanner.projector.size};
  const VirtualScan taken = take_colour_scan(world.scanner, world.scene, pattern_set(sequence),
                                             world.photometry, {usual_mixture, 0.5});
  const std::string path = folder.path() / "scan.slip";
  save_virtual_scan(path, sequence, world, taken);
  const auto frames_from = [](NamedSource& opened) {
    std::vector<Frame> frames;
    opened.frames->start();
    for (Frame frame; opened.frames->next(frame, 1000ms) == Arrival::frame;) {
      frames.push_back(frame);
    }
    return frames;
  };
  const auto expect_same = [](const std::vector<Frame>& a, const std::vector<Frame>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t n = 0; n < a.size(); ++n) {
      EXPECT_EQ(a[n].format(), b[n].format());
      EXPECT_TRUE(same_pixels(a[n], b[n])) << n;
    }
  };
  SourceRequest request{.source = "replay:" + path, .rate = 0};
  NamedSource apart = open_source(request);
  EXPECT_FALSE(apart.in_colour);
  EXPECT_EQ(apart.warning, "");
  expect_same(frames_from(apart),
              frames_of(unmixed(taken.frames, usual_mixture, taken.white), "apart"));
  request.as_taken = true;
  NamedSource kept = open_source(request);
  EXPECT_TRUE(kept.in_colour);
  EXPECT_EQ(kept.white.count(), 3);
  expect_same(frames_from(kept), frames_of(taken.frames, "taken"));
  request.sequence.settings = {{"steps", "4"}};
  expect_error([&] { (void)open_source(request); }, {path, "4 frames", "a multiple of 3"});
}

TEST(NamedSource, OpenSourceNamesWhatThereIs) {
  for (const char* const scheme : {"virtual", "replay:", "v4l2:"}) {
    EXPECT_NE(source_forms().find(scheme), std::string::npos) << scheme;
  }
  EXPECT_EQ(scheme_of("replay:scan.slip"), "replay");
  expect_error([] { (void)open_source({.source = "telepathy:now"}); }, {"telepathy", "replay"});
}

TEST(NamedSource, OpenCameraRefusesNamesThatNameNone) {
  expect_error([] { open_camera("tape:1", {}); }, {"tape:1", "aravis:NAME, v4l2:NUMBER"});
  expect_error([] { open_camera("v4l2:x", {}); }, {"v4l2:x", "v4l2:0"});
  expect_error([] { open_camera("v4l2:-1", {}); }, {"v4l2:-1"});
  expect_error([] { open_camera("v4l2", {}); }, {"expected a number"});
}

TEST(NamedSource, OpenCameraSaysWhichCameraDoesNotAnswer) {
  EXPECT_THROW(open_camera("v4l2:4000", {}), WorldError);
}

TEST(NamedSource, OpenCameraRefusesSettingsBeforeItLooksForTheCamera) {
  EXPECT_THROW(open_camera("v4l2:4000", {.trigger = "Line1"}), Error);
}

TEST(NamedSource, ListCamerasNamesThemAsTheyAreOpened) {
  for (const CameraDescription& camera : list_cameras()) {
    EXPECT_TRUE(camera.name.starts_with("aravis:") || camera.name.starts_with("v4l2:"))
        << camera.name;
  }
}

}  // namespace slipstream::named_source_test
