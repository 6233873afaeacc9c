// Three patterns in the colours of one picture: taken apart by a measured mixture they are three
// frames like others.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "frames/colour_channels.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/pattern_set.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::colour_test {

/// A lamp in the room, blur and noise, as in the other codings of one frame.
Photometry bench() {
  Photometry photometry{.ambient = 5, .noise_variance = 1.6, .bits = 8};
  photometry.physics.camera.blur = 0.6;
  return photometry;
}

ColourMixture mixture_of_white_board(const Scanner& scanner) {
  return measured_mixture(take_colour_scan(scanner, scene_named("board", scanner),
                                           primary_patterns({}), bench(), {usual_mixture})
                              .frames);
}

TEST(ColourMixture, IsFoundOnAWhiteSurface) {
  const ColourMixture found = mixture_of_white_board(example_scanner({320, 240}));
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t p = 0; p < 3; ++p) {
      const double gain = (usual_mixture[0][0] + usual_mixture[1][1] + usual_mixture[2][2]) / 3;
      EXPECT_NEAR(found[c][p], usual_mixture[c][p] / gain, 0.005) << c << " " << p;
    }
  }
}

TEST(ColourMixture, IsRefusedWhereColoursCannotBeToldApart) {
  const Scanner scanner = example_scanner({64, 48});
  const Scene board = scene_named("board", scanner);
  const ColourMixture grey{{{1, 1, 1, 0}, {1, 1, 1, 0}, {1, 1, 1, 0}}};
  EXPECT_THROW(measured_mixture(
                   take_colour_scan(scanner, board, primary_patterns({}), bench(), {grey}).frames),
               Error);
  EXPECT_THROW(measured_mixture(FrameSet(FrameSet::Images8(3, Image<std::uint8_t>({8, 8})))),
               Error);
  EXPECT_THROW(measured_mixture(FrameSet(FrameSet::Images8(12, Image<std::uint8_t>({8, 8})))),
               Error);
  EXPECT_THROW(unmixed(FrameSet(FrameSet::Images8(4, Image<std::uint8_t>({8, 8}))), usual_mixture),
               Error);
  ColourMixture broken = usual_mixture;
  broken[1][3] = NAN;
  EXPECT_THROW(require_valid(broken), Error);
}

TEST(ColourMixture, LeavesWhatIsSaturatedSaturated) {
  FrameSet::Images8 images(3, Image<std::uint8_t>({16, 1}, 100));
  images[1](3, 0) = 255;
  const FrameSet alone = unmixed(FrameSet(images), usual_mixture);
  const Image<std::uint8_t> saturated = saturation_mask(alone);
  for (int column = 0; column < 16; ++column) {
    EXPECT_EQ(saturated(column, 0), column == 3 ? 1 : 0);
  }
}

struct Errors {
  double share = 0;  ///< of the lit pixels that have points
  double median = 0, nine_tenths = 0;
};

Errors errors_of(const FrameViews& frames, const VirtualScan& scan, const Scanner& scanner,
                 const Strategy& strategy) {
  Engine engine(scanner, {.strategy = strategy});
  Cloud cloud;
  engine.cloud(frames, cloud);
  std::vector<double> errors;
  double lit = 0;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (std::isnan(scan.coordinate.begin()[i])) continue;
    ++lit;
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    errors.push_back(std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]));
  }
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  return {static_cast<double>(errors.size()) / lit, errors[errors.size() / 2],
          errors[errors.size() * 9 / 10]};
}

/// One picture of three steps, and two of two frequencies, of grey surfaces and of painted ones.
TEST(ColourScans, AreThoseOfGreyFramesOnceTheMixtureIsKnown) {
  const Scanner scanner = example_scanner({320, 240});
  const ColourMixture mixture = mixture_of_white_board(scanner);
  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}),
        Strategy(DualFrequency{.steps = 3, .high = 16, .low = 1}), Strategy(DeBruijn{})}) {
    for (const char* const name : {"board", "sphere", "statue"}) {
      const Scene scene = scene_named(name, scanner);
      const PatternSet patterns = pattern_set(strategy, Axis::x);
      const VirtualScan grey = take_scan(scanner, scene, patterns, bench());
      const Errors of_grey = errors_of(grey.frames, grey, scanner, strategy);
      for (const double paint : {0.0, 0.3}) {
        const VirtualScan scan =
            take_colour_scan(scanner, scene, patterns, bench(), {usual_mixture, paint});
        const Errors before = errors_of(scan.frames, scan, scanner, strategy),
                     after = errors_of(unmixed(scan.frames, mixture), scan, scanner, strategy);
        std::cout << label_of(strategy) << " of " << name << ", paint " << paint << ": grey "
                  << of_grey.share << " " << of_grey.median << " " << of_grey.nine_tenths
                  << " mm; mixed " << before.share << " " << before.median << " "
                  << before.nine_tenths << "; taken apart " << after.share << " " << after.median
                  << " " << after.nine_tenths << '\n';
        const Errors whitened =
            errors_of(unmixed(scan.frames, mixture, scan.white), scan, scanner, strategy);
        std::cout << "  with a white picture " << whitened.share << " " << whitened.median << " "
                  << whitened.nine_tenths << '\n';
        EXPECT_GT(whitened.share, of_grey.share - 0.05);
        EXPECT_LT(whitened.median, 4 * of_grey.median);
        if (paint > 0) continue;
        EXPECT_GT(after.share, of_grey.share - 0.05);
        EXPECT_LT(after.median, 3 * of_grey.median);
        EXPECT_LT(after.median, before.median / 2);
      }
    }
  }
}

}  // namespace slipstream::colour_test
