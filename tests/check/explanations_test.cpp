#include "check/explanations.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "check/mistake_search.h"
#include "check/out_of_step.h"
#include "check/possible_mistakes.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "tests/check/synthetic_scan.h"

namespace slipstream::synthetic_frames_test {

const Strategy fringes = make_strategy("dual-frequency", {{"steps", 4}});

/// Frames of a plane 600 mm away.
Level on_plane(const Strategy& strategy, const Scanner& scanner) {
  return [=](int n, int column, int row) {
    const Eigen::Vector3d point = 600 * ray_through(scanner.camera, {column, row});
    const double y = project(scanner.projector, in_projector_frame(scanner, point)).x() /
                     scanner.projector.size.width;
    return y < 0 || y > 1 ? 20 : 20 + 200 * strategy.shape(n, y);
  };
}

/// The only finding.
Finding explained(const JudgedScan& scan, const Fit& fit) {
  const auto findings = explain(scan, fit).findings;
  EXPECT_EQ(findings.size(), 1U);
  return findings.at(0);
}

TEST(Explanations, OfACoordinateThatRunsBackAreHopeless) {
  const Scanner scanner = example_scanner(size);
  const SyntheticScan scan(fringes, [](int n, int column, int) {
    return 20 + 200 * fringes.shape(n, 0.5 + 0.02 * along(column));
  });
  Fit fit = fit_of(scan.judged());
  for (const auto& [slope, severity] :
       {std::pair(-1.0, Severity::wrong), std::pair(0.1, Severity::doubtful)}) {
    fit.geometry = GeometryEvidence{.slope = slope, .slope_doubt = 0.1};
    EXPECT_EQ(explained(scan.judged(&scanner), fit).severity, severity) << slope;
  }
}

// The other direction of the shifts would put the points between the boards.
TEST(Explanations, OfDepthsBeyondTheBoardsAloneAreDoubtful) {
  const Scanner scanner = example_scanner(size);
  const SyntheticScan scan(make_strategy("dual-frequency", {{"steps", 4}, {"backwards", true}}),
                           on_plane(fringes, scanner));
  Fit fit = fit_of(scan.judged());
  fit.geometry = GeometryEvidence{.beyond = 1};
  const Finding finding = explained(scan.judged(&scanner), fit);
  EXPECT_EQ(finding.kind, FindingKind::better_settings);
  EXPECT_EQ(finding.severity, Severity::doubtful) << text_of(finding);
}

// Stripes of 320 / 35.76 pixels beside periods of 320 / 36: on average 1/8 of a period away, a
// step.
TEST(Explanations, OfStripesOfAnotherWidthAreNoOrigin) {
  const auto with_periods = [](double periods) {
    return make_strategy("gray-phase", {{"steps", 8}, {"periods", periods}, {"bits", 6}});
  };
  const Strategy sinusoids_of = with_periods(36), stripes_of = with_periods(35.76);
  const SyntheticScan scan(sinusoids_of, [&](int n, int column, int) {
    return 20 + 200 * (n < 8 ? sinusoids_of : stripes_of).shape(n, along(column));
  });
  const Finding finding = explained(scan.judged(), fit_of(scan.judged()));
  EXPECT_EQ(finding.severity, Severity::doubtful) << text_of(finding);
  EXPECT_TRUE(finding.remedies.front().settings.empty()) << text_of(finding);
}

// Two percent of the frame before move 48 periods by less than their noise.
TEST(Explanations, OfMixedFramesDependOnTheDepth) {
  const Scanner scanner = example_scanner(size);
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}, {"high", 48}});
  const Level right = on_plane(strategy, scanner);
  const SyntheticScan scan(strategy, [&](int n, int column, int row) {
    return 0.98 * right(n, column, row) + 0.02 * right((n + 7) % 8, column, row);
  });
  Fit fit = fit_of(scan.judged(&scanner));
  EXPECT_EQ(mixed_frames(scan.judged(&scanner), fit)->finding.severity, Severity::doubtful);
  fit.geometry->median_depth += 5;
  EXPECT_EQ(mixed_frames(scan.judged(&scanner), fit)->finding.severity, Severity::wrong);
}

TEST(Explanations, OfCroppedPicturesPutTheAxisInTheirMiddle) {
  Scanner scanner = example_scanner(size);
  scanner.camera.intrinsic(0, 2) = scanner.camera.intrinsic(1, 2) = 50;
  const SyntheticScan scan(fringes, shown(fringes, 20, 200));
  const auto mistakes = possible_mistakes(scan.judged(&scanner), {});
  const auto cropped =
      std::ranges::find(mistakes, CauseKind::picture_size,
                        [](const PossibleMistake& mistake) { return mistake.cause.kind; });
  ASSERT_NE(cropped, mistakes.end());
  EXPECT_EQ(cropped->scanner->camera.intrinsic(0, 2), 159.5);
  EXPECT_EQ(cropped->scanner->camera.intrinsic(1, 2), 119.5);
}

// Frames that are wrong are not called dim, too.
TEST(Explanations, OfSwappedFramesNeedNoMoreLight) {
  const Level dim = shown(fringes, 20, 26);
  for (const bool swapped : {false, true}) {
    const auto pictures = pictures_of(fringes.layout().frames, [&](int n, int column, int row) {
      return dim(swapped && n < 2 ? 1 - n : n, column, row);
    });
    const auto findings =
        check_frames(FrameSet(pictures, 8), {.strategy = fringes, .projector = size}, {},
                     {.minimum_modulation = 15})
            .findings;
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings.front().kind == FindingKind::low_modulation, !swapped);
  }
}

// Frames are put in order only if nothing else fits.
TEST(Explanations, OfSlippedFramesRepairThemIfTheyAreTheOnlyOne) {
  const auto order_of = [](std::size_t count) {
    std::vector<Attempt> attempts(
        count, {.mistake = {.cause = {}, .order = {1, 0}, .slipped = true}, .fit = {}});
    attempts.back().mistake.cause.text = "the last";
    return explanation_from(attempts).order;
  };
  EXPECT_EQ(order_of(1), (FrameOrder{1, 0}));
  EXPECT_EQ(order_of(2), FrameOrder());
}

}  // namespace slipstream::synthetic_frames_test
