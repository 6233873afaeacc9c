// Broken calibrations, whose cause must be named, and good ones, which must give no
// diagnostics.
#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "slipstream/calibration_board.h"
#include "tests/calibrate/told_calibration.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/own_strategies.h"

namespace slipstream::doctor_test {

struct BrokenCase {
  std::string name;
  std::string cause;  ///< expected in the diagnostic or error
  std::function<Told()> told;
};

void PrintTo(const BrokenCase& broken, std::ostream* out) {
  *out << broken.name;
}

BrokenCase of_frames(std::string name, std::string cause, const BoardScene& scene) {
  return {std::move(name), std::move(cause), [scene] { return told_of(scene); }};
}

void rotate_by_one(Pictures& pictures, std::size_t first, std::size_t count) {
  const auto begin = pictures.begin() + static_cast<std::ptrdiff_t>(first);
  std::rotate(begin, begin + 1, begin + static_cast<std::ptrdiff_t>(count));
}

/// Scales the contrast of the first `count` pictures about their mean, as defocus does to fine
/// fringes.
void fade(Pictures& pictures, std::size_t count, double contrast) {
  for (std::size_t i = 0; i < pictures[0].pixel_count(); ++i) {
    double mean = 0;
    for (std::size_t n = 0; n < count; ++n) {
      mean += pictures[n].begin()[i] / static_cast<double>(count);
    }
    for (std::size_t n = 0; n < count; ++n) {
      std::uint8_t& grey = pictures[n].begin()[i];
      grey = static_cast<std::uint8_t>(std::lround(mean + contrast * (grey - mean)));
    }
  }
}

std::vector<BrokenCase> broken_frames() {
  const Strategy fine = DualFrequency{.steps = 3, .high = 16, .low = 1};
  const Strategy four = DualFrequency{.steps = 4, .high = 16, .low = 1};
  const Photometry usual = BoardScene{}.photometry;
  const auto with_gamma = [&](double gamma) {
    Photometry photometry = usual;
    photometry.response = PowerLaw{gamma};
    return photometry;
  };
  return {
      of_frames("gamma_2_2_under_three_steps", "uncorrected gamma",
                {.strategy = fine, .photometry = with_gamma(2.2)}),
      of_frames("gamma_1_5_under_three_steps", "uncorrected gamma",
                {.photometry = with_gamma(1.5)}),
      of_frames("gamma_0_6_under_four_steps", "uncorrected gamma",
                {.strategy = four, .photometry = with_gamma(0.6)}),
      of_frames("one_pose_begun_a_frame_late",
                "the frames have slipped: the cycle begins at frame 5",
                {.spoil =
                     [](Pictures& pictures, int pose, Axis) {
                       if (pose == 2) rotate_by_one(pictures, 0, pictures.size());
                     }}),
      of_frames("fine_fringes_a_step_late_in_one_scan", "frames 0 to 3 look rotated by 1",
                {.strategy = four,
                 .spoil =
                     [](Pictures& pictures, int pose, Axis axis) {
                       if (pose == 4 && axis == Axis::y) rotate_by_one(pictures, 0, 4);
                     }}),
      of_frames("two_frames_exchanged_in_one_pose", "frames 1 and 2 look swapped",
                {.strategy = four,
                 .spoil =
                     [](Pictures& pictures, int pose, Axis) {
                       if (pose == 1) std::swap(pictures[1], pictures[2]);
                     }}),
      of_frames("all_poses_begun_a_frame_late",
                "the frames have slipped: the cycle begins at frame 5",
                {.spoil = [](Pictures& pictures, int,
                             Axis) { rotate_by_one(pictures, 0, pictures.size()); }}),
      of_frames("other_periods_than_said", "patterns of 8 periods, configured as 16",
                {.said_strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}}),
      of_frames("camera_out_of_focus", "the camera is out of focus",
                {.spoil = [](Pictures& pictures, int, Axis) { blur(pictures, 2.2); }}),
      of_frames("projector_out_of_focus", "the projector is out of focus",
                {.strategy = fine,
                 .spoil = [](Pictures& pictures, int, Axis) { fade(pictures, 3, 0.35); }}),
      of_frames("a_row_of_corners_too_few", "`corners`",
                {.said_board = CalibrationBoard{.columns = 9, .rows = 5, .spacing = 20}}),
      of_frames("circles_of_another_count", "`corners`",
                {.board = {.kind = BoardKind::circles, .columns = 5, .rows = 8, .spacing = 16},
                 .said_board =
                     CalibrationBoard{
                         .kind = BoardKind::circles, .columns = 6, .rows = 8, .spacing = 16}}),
      of_frames("too_dark", "too dark",
                {.spoil =
                     [](Pictures& pictures, int, Axis) {
                       for (auto& picture : pictures) {
                         for (std::uint8_t& grey : picture)
                           grey = static_cast<std::uint8_t>(grey / 26);
                       }
                     }}),
      of_frames("overexposed", "overexposed",
                {.spoil =
                     [](Pictures& pictures, int, Axis) {
                       for (auto& picture : pictures) {
                         for (std::uint8_t& grey : picture) {
                           grey = static_cast<std::uint8_t>(std::min(255, 5 * grey));
                         }
                       }
                     }}),
  };
}

/// A board that fills most of both images, and eight good poses.
struct Corners {
  CalibrationBoard board{.columns = 9, .rows = 6, .spacing = 20};
  Scanner scanner = example_scanner();
  std::vector<Eigen::Vector3d> places = printed_places(board);
  int poses = 8;
  GeometryCalibrationSettings settings{.camera_coefficients = 2, .projector_coefficients = 2};
  std::vector<BoardView> views{};  ///< empty: good_views()
};

VirtualViews good_views(const Corners& corners) {
  return virtual_views(corners.scanner, corners.board, corners.places, corners.poses, 0.05);
}

Told told_of(const Corners& corners) {
  try {
    return {calibrate_geometry(corners.views.empty() ? good_views(corners).views : corners.views,
                               corners.board, corners.scanner.camera.size,
                               corners.scanner.projector.size, corners.settings)
                .findings,
            ""};
  } catch (const Error& error) {
    return {{}, error.what()};
  }
}

BrokenCase of_corners(std::string name, std::string cause,
                      const std::function<void(Corners& corners)>& breaks) {
  return {std::move(name), std::move(cause), [breaks] {
            Corners corners;
            breaks(corners);
            return told_of(corners);
          }};
}

/// A case in which `change` alters projector pixels.
BrokenCase of_pixels(std::string name, std::string cause,
                     const std::function<void(std::size_t pose, Eigen::Vector2d& pixel)>& change) {
  return of_corners(std::move(name), std::move(cause), [change](Corners& corners) {
    corners.views = good_views(corners).views;
    for (std::size_t v = 0; v < corners.views.size(); ++v) {
      for (Eigen::Vector2d& pixel : corners.views[v].projector) change(v, pixel);
    }
  });
}

/// Rotates the projector relative to the camera, as a knock does.
Scanner knocked(Scanner scanner, double degrees) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 1, 0.3).normalized();
  scanner.rotation = Eigen::AngleAxisd(degrees / 57.29578, axis) * scanner.rotation;
  return scanner;
}

/// The corners of a board in `pose` seen by another scanner, with the noise of `view`.
BoardView seen_by(const Scanner& scanner, const Corners& corners, const Eigen::Isometry3d& pose,
                  const BoardView& view, const Eigen::Isometry3d& pose_of_view) {
  BoardView seen = view;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d is = pose * corners.places[i], was = pose_of_view * corners.places[i];
    const Scanner& before = corners.scanner;
    seen.camera[i] += project(scanner.camera, is) - project(before.camera, was);
    seen.projector[i] += project(scanner.projector, in_projector_frame(scanner, is)) -
                         project(before.projector, in_projector_frame(before, was));
  }
  return seen;
}

/// Good views, with the poses `of_other` seen by another scanner.
void mix(Corners& corners, const Scanner& other, const std::vector<std::size_t>& of_other) {
  const VirtualViews good = good_views(corners);
  corners.views = good.views;
  for (const std::size_t v : of_other) {
    corners.views[v] = seen_by(other, corners, good.poses[v], good.views[v], good.poses[v]);
  }
}

void bend(Corners& corners, const std::function<double(double u, double v)>& height) {
  for (Eigen::Vector3d& place : corners.places) {
    place.z() = height(place.x() / corners.places.back().x() * 2 - 1,
                       place.y() / corners.places.back().y() * 2 - 1);
  }
}

/// Repeats the first pose with almost no rotation.
void hold_parallel(Corners& corners) {
  const VirtualViews good = good_views(corners);
  corners.views.clear();
  for (std::size_t v = 0; v < good.views.size(); ++v) {
    Eigen::Isometry3d pose = good.poses[0];
    pose.rotate(Eigen::AngleAxisd(0.015 * static_cast<double>(v), Eigen::Vector3d::UnitX()));
    pose.pretranslate(Eigen::Vector3d(0, 0, 8.0 * static_cast<double>(v)));
    corners.views.push_back(seen_by(corners.scanner, corners, pose, good.views[v], good.poses[v]));
  }
}

std::vector<BrokenCase> broken_corners() {
  using Pixel = Eigen::Vector2d;
  return {
      of_corners("board_bent_like_a_roof_tile", "a bent board",
                 [](Corners& corners) { bend(corners, [](double u, double) { return u * u; }); }),
      of_corners("board_bent_and_print_held_exact", "a bent board",
                 [](Corners& corners) {
                   bend(corners, [](double u, double) { return u * u; });
                   corners.settings.print_deviation = std::nullopt;
                 }),
      of_corners("board_twisted", "a bent board",
                 [](Corners& corners) { bend(corners, [](double u, double v) { return u * v; }); }),
      of_corners("print_stretched_by_one_percent", "stretched along one axis",
                 [](Corners& corners) {
                   for (Eigen::Vector3d& place : corners.places) place.y() *= 1.01;
                 }),
      of_corners("board_never_tilted", "too few tilts", hold_parallel),
      of_corners("four_poses", "too few poses", [](Corners& corners) { corners.poses = 4; }),
      of_corners("small_board_in_the_middle", "boards held only in the middle",
                 [](Corners& corners) {
                   corners.board = {.columns = 7, .rows = 5, .spacing = 12};
                   corners.places = printed_places(corners.board);
                 }),
      of_pixels("axes_swapped", "swapped",
                [](std::size_t, Pixel& pixel) { std::swap(pixel.x(), pixel.y()); }),
      of_pixels("projector_mirrored", "mirrored",
                [](std::size_t, Pixel& pixel) { pixel.x() = 1279 - pixel.x(); }),
      of_pixels("one_pose_mirrored", "mirrored",
                [](std::size_t pose, Pixel& pixel) {
                  if (pose == 3) pixel.y() = 799 - pixel.y();
                }),
      of_pixels("board_moved_between_the_axes", "the board moved between the scans",
                [](std::size_t pose, Pixel& pixel) {
                  if (pose == 5) pixel.y() += 4;
                }),
      of_pixels("board_moved_far_between_the_axes", "the board moved between the scans",
                [](std::size_t pose, Pixel& pixel) {
                  if (pose == 2) pixel.x() += 25;
                }),
      of_pixels("another_projector_size_than_said", "another projector size",
                [](std::size_t, Pixel& pixel) { pixel.y() *= 720.0 / 800; }),
      of_corners("slip_that_only_the_geometry_shows", "a slip",
                 [](Corners& corners) {
                   corners.views = good_views(corners).views;
                   // Eight steps of one period; one pose starts a frame late.
                   for (BoardView& view : corners.views) {
                     view.signs.x = {.steps = 8, .period = 1280};
                     view.signs.y = {.steps = 8, .period = 800};
                   }
                   for (Pixel& pixel : corners.views[3].projector) pixel.x() += 1280.0 / 8;
                 }),
      of_corners("rig_knocked_a_little_half_way", "the rig was moved",
                 [](Corners& corners) {
                   mix(corners, knocked(corners.scanner, 0.1), {4, 5, 6, 7});
                 }),
      of_corners("rig_knocked_half_way", "the rig was moved",
                 [](Corners& corners) {
                   mix(corners, knocked(corners.scanner, 2), {4, 5, 6, 7});
                 }),
      of_corners("cameras_mixed", "frames of two cameras are mixed",
                 [](Corners& corners) {
                   Scanner other = corners.scanner;
                   other.camera.intrinsic(0, 0) = other.camera.intrinsic(1, 1) = 1000;
                   other.translation.x() += 20;
                   mix(corners, other, {1, 3, 5, 7});
                 }),
      {"print_of_the_wrong_scale", "wrong scale",
       [] {
         return Told{findings_of_ruler({.columns = 13, .rows = 9, .spacing = 10}, {121.9, 81.3}),
                     ""};
       }},
      {"print_longer_in_its_columns", "stretched along one axis",
       [] {
         return Told{findings_of_ruler({.columns = 13, .rows = 9, .spacing = 10}, {120, 81.5}), ""};
       }},
  };
}

class DoctorBrokenCalibration : public testing::TestWithParam<BrokenCase> {};

TEST_P(DoctorBrokenCalibration, IsToldByItsCause) {
  const Told told = GetParam().told();
  EXPECT_TRUE(names(told, GetParam().cause)) << "not told: " << GetParam().cause << ", but\n"
                                             << text_of(told);
  EXPECT_EQ(told.error.find('\n'), std::string::npos) << told.error;
}

const auto name_of_case = [](const auto& broken) { return broken.param.name; };

INSTANTIATE_TEST_SUITE_P(Frames, DoctorBrokenCalibration, testing::ValuesIn(broken_frames()),
                         name_of_case);
INSTANTIATE_TEST_SUITE_P(Corners, DoctorBrokenCalibration, testing::ValuesIn(broken_corners()),
                         name_of_case);

struct GoodCase {
  std::string name;
  BoardScene scene;
};

void PrintTo(const GoodCase& good, std::ostream* out) {
  *out << good.name;
}

std::vector<GoodCase> good_calibrations() {
  const CalibrationBoard chessboard{.columns = 13, .rows = 9, .spacing = 15};
  const CalibrationBoard circles{
      .kind = BoardKind::circles, .columns = 6, .rows = 9, .spacing = 16};
  const CalibrationBoard charuco{
      .kind = BoardKind::charuco, .columns = 11, .rows = 7, .spacing = 17};
  const auto scene = [](const CalibrationBoard& board, const Strategy& strategy, double noise,
                        int poses, Size camera) {
    return BoardScene{.board = board,
                      .strategy = strategy,
                      .photometry = {.ambient = 5, .noise_variance = noise, .bits = 8},
                      .camera = camera,
                      .poses = poses};
  };
  const Strategy three = DualFrequency{.steps = 3, .high = 8, .low = 1};
  const Strategy four = DualFrequency{.steps = 4, .high = 16, .low = 1};
  const Strategy multiplexed = PhaseChannelMultiplexing{.steps = 5, .high = 8};
  const Size small{320, 240}, middle{480, 360};
  return {{"chessboard", scene(chessboard, three, 1.55, 12, small)},
          {"circles", scene(circles, four, 1.55, 12, small)},
          {"charuco", scene(charuco, three, 1.55, 10, middle)},
          {"noise", scene(chessboard, four, 6, 12, small)},
          {"three_frequencies", scene(chessboard, ThreeFrequencies{}, 1.55, 12, small)},
          {"multiplexed", scene(chessboard, multiplexed, 1.55, 12, small)}};
}

class DoctorGoodCalibration : public testing::TestWithParam<GoodCase> {};

TEST_P(DoctorGoodCalibration, GetsNoRemark) {
  const Told told = told_of(GetParam().scene);
  EXPECT_EQ(text_of(told), "");
}

INSTANTIATE_TEST_SUITE_P(Boards, DoctorGoodCalibration, testing::ValuesIn(good_calibrations()),
                         [](const auto& good) { return good.param.name; });

// The second harmonic of ((1 + cos a) / 2)^gamma is (gamma - 1) / (gamma + 2) of the first, and
// three steps add it to the phase, in rad.
TEST(Doctor, RippleIsTheSecondHarmonicOfAGamma) {
  BoardScene scene{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}, .poses = 4};
  scene.photometry.response = PowerLaw{1.2};
  const std::vector<Finding> findings = told_of(scene).findings;
  const auto ripple = std::ranges::find(findings, FindingKind::phase_ripple, &Finding::kind);
  ASSERT_NE(ripple, findings.end());
  EXPECT_NEAR(ripple->evidence[0].value, 0.2 / 3.2, 0.005);
}

TEST(Doctor, UncorrectedGammaIsNotToldOnceItIsCorrected) {
  BoardScene scene{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}, .poses = 4};
  scene.photometry.response = PowerLaw{2.2};
  EXPECT_TRUE(names(told_of(scene), "uncorrected gamma"));
  scene.response = MeasuredResponse{PowerLaw{2.2}, 2.2};
  const Told told = told_of(scene);
  EXPECT_EQ(told.error, "");
  EXPECT_FALSE(names(told, "gamma")) << text_of(told);
}

}  // namespace slipstream::doctor_test
