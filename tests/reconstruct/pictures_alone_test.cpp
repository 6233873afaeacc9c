// What frames say where no scanner is known.
#include <algorithm>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::pictures_alone_test {

constexpr Size camera{96, 72};

EngineSetup calibrated() {
  return {.scanner = example_scanner(camera),
          .sequence = {.strategy = DualFrequency{.steps = 4, .high = 16}, .axis = Axis::x}};
}

EngineSetup uncalibrated() {
  EngineSetup setup = calibrated();
  setup.scanner = without_geometry(camera, {});
  return setup;
}

FrameSet frames_under(const Photometry& light) {
  const EngineSetup setup = calibrated();
  return scan_of_scene("statue", setup.scanner, pattern_set(setup.sequence), light).frames;
}

TEST(PicturesAlone, HaveTheMapsThatTheScannerGives) {
  const FrameSet frames = frames_under({.ambient = 5, .noise_variance = 1});
  for (const EngineKind kind : {EngineKind::automatic, EngineKind::reference}) {
    EngineSetup known = calibrated(), unknown = uncalibrated();
    known.settings.engine = unknown.settings.engine = kind;
    Maps with, without;
    Engine(known).maps(frames, with);
    Engine(unknown).maps(frames, without);
    const auto same = [](const Image<float>& a, const Image<float>& b) {
      return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
    };
    EXPECT_TRUE(same(with.modulation, without.modulation));
    EXPECT_TRUE(same(with.wrapped_phase, without.wrapped_phase));
    EXPECT_TRUE(same(with.coordinate, without.coordinate));
  }
}

TEST(PicturesAlone, GiveNoPoints) {
  const FrameSet frames = frames_under({});
  Engine engine(uncalibrated());
  Cloud cloud;
  Depth depth;
  Maps maps;
  EXPECT_THROW(engine.cloud(frames, cloud), Error);
  EXPECT_THROW(engine.depth(frames, depth), Error);
  EXPECT_THROW(engine.cloud_and_maps(frames, cloud, maps), Error);
  engine.maps(frames, maps);
  EXPECT_THROW(static_cast<void>(engine.uncertainty(cloud, maps, frames)), Error);
}

TEST(PicturesAlone, PictureReportTellsWhichPixelsAreTooDarkAndWhichSaturated) {
  const auto report_of = [](const Photometry& light) {
    const FrameSet frames = frames_under(light);
    Maps maps;
    Engine(uncalibrated()).maps(frames, maps);
    return picture_report(frames, maps, {});
  };
  const auto share = [](const PictureReport& report, Validity kind) {
    const auto counts = count_by_validity(report.validity);
    return static_cast<double>(counts[static_cast<std::size_t>(kind)]) /
           static_cast<double>(report.validity.pixel_count());
  };
  const PictureReport right = report_of({}), bright = report_of({.ambient = 200});
  EXPECT_GT(share(right, Validity::valid), 0.5);
  EXPECT_EQ(share(right, Validity::saturated), 0);
  EXPECT_GT(right.modulation, 20);
  EXPECT_GT(share(bright, Validity::saturated), 0.2);

  Image<std::uint8_t> black({8, 6});
  const Frames<std::uint8_t> frames{black, black};
  const Maps dark{.modulation = Image<float>({8, 6})};
  const PictureReport nothing = picture_report(frames, dark, {});
  EXPECT_EQ(share(nothing, Validity::too_dark), 1);
  EXPECT_EQ(nothing.modulation, 0);
}

}  // namespace slipstream::pictures_alone_test
