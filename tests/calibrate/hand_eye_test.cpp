#include "calibrate/hand_eye.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "calibrate/hand_eye_report.h"
#include "calibrate/virtual_robot.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream::hand_eye_test {

const PoseConvention kuka{.rotation = *notation_of_robot("kuka")};
const PoseConvention vectors{.rotation = {.kind = RotationNotation::Kind::vector}};

struct Tables {
  PoseTable robot, boards;
};

std::vector<Eigen::Isometry3d> poses_of_run(const RobotRun& run,
                                            const Eigen::Isometry3d PosePair::*which) {
  std::vector<Eigen::Isometry3d> poses;
  for (const PosePair& pair : run.pairs) poses.push_back(pair.*which);
  return poses;
}

Tables tables_of(const RobotRun& run, const PoseConvention& robot = kuka,
                 const PoseConvention& boards = vectors) {
  return {table_of(poses_of_run(run, &PosePair::robot), robot),
          table_of(poses_of_run(run, &PosePair::board), boards)};
}

HandEye calibrated(const Tables& tables, EyePlace place = EyePlace::in_hand) {
  return calibrate_hand_eye(tables.robot, tables.boards,
                            {.place = place, .robot = "", .boards = ""});
}

struct Off {
  Eigen::Vector3d rotation, translation;  ///< rad, mm
};

Off off(const HandEye& found, const RobotRun& run) {
  const Eigen::Isometry3d &camera = found.poses.camera, &truth = run.truth.camera;
  return {vector_of(truth.linear().transpose() * camera.linear()),
          camera.translation() - truth.translation()};
}

/// Calls `use` with rigs of one kind, their calibration and its error.
template <class Use>
void for_each_rig(EyePlace place, int count, VirtualRobot robot, const Use& use) {
  robot.place = place;
  for (int rig = 1; rig <= count; ++rig) {
    robot.seed = static_cast<std::uint32_t>(rig);
    const RobotRun run = moved_robot(robot);
    const HandEye found = calibrated(tables_of(run), place);
    use(found, off(found, run));
  }
}

std::string message_of(const Tables& tables, const HandEyeSettings& settings = {}) {
  try {
    calibrate_hand_eye(tables.robot, tables.boards, settings);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

class HandEyeRigs : public testing::TestWithParam<EyePlace> {};

TEST_P(HandEyeRigs, ErrorsAreThoseThatItsDeviationsSay) {
  constexpr int rigs = 30;
  double squares = 0;
  std::vector<double> rotations, translations;
  for_each_rig(GetParam(), rigs, {}, [&](const HandEye& found, const Off& error) {
    squares += error.rotation.cwiseQuotient(found.rotation_deviation).squaredNorm() +
               error.translation.cwiseQuotient(found.translation_deviation).squaredNorm();
    rotations.push_back(error.rotation.norm());
    translations.push_back(error.translation.norm());
  });

  const double rms = std::sqrt(squares / (6 * rigs));
  EXPECT_GT(rms, 0.8);
  EXPECT_LT(rms, 1.2);
  EXPECT_LT(median(translations), 0.15);
  EXPECT_LT(median(rotations), 0.02 * degree);
}

TEST_P(HandEyeRigs, ARobotWithoutErrorsIsFoundBetter) {
  std::vector<double> translations;
  for_each_rig(
      GetParam(), 10, {.rotation_error = 0, .translation_error = 0},
      [&](const HandEye&, const Off& error) { translations.push_back(error.translation.norm()); });
  EXPECT_LT(median(translations), 0.05);
}

/// Robots, directions and units, with two poses swapped in every second case.
TEST_P(HandEyeRigs, FindsTheConventionsOfAllRobots) {
  std::uint32_t seed = 100;
  for (const std::string& robot : robot_names()) {
    for (const bool inverse : {false, true}) {
      for (const double unit : {1.0, 1000.0}) {
        ++seed;
        const bool swapped = seed % 2 == 0;
        RobotRun run = moved_robot({.place = GetParam(), .seed = seed});
        if (swapped) std::swap(run.pairs[3].robot, run.pairs[9].robot);

        const PoseConvention written{*notation_of_robot(robot), unit, inverse};
        const HandEye found = calibrated(tables_of(run, written), GetParam());
        EXPECT_EQ(name_of(found.robot, robot_frames), name_of(written, robot_frames));
        EXPECT_LT(off(found, run).translation.norm(), 1) << robot << " " << seed;

        for (std::size_t i = 0; i < found.each.size(); ++i) {
          EXPECT_EQ(found.each[i].used, !swapped || (i != 3 && i != 9)) << robot << " pose " << i;
        }
        if (swapped) {
          EXPECT_EQ(found.each[3].reason, "swapped with pose 10");
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Eyes, HandEyeRigs, testing::Values(EyePlace::in_hand, EyePlace::to_hand),
                         [](const auto& place) {
                           return place.param == EyePlace::in_hand ? "InHand" : "ToHand";
                         });

TEST(HandEye, FindsTheConventionOfTheBoards) {
  const RobotRun run = moved_robot({.seed = 7});
  const std::vector<PoseConvention> all = conventions_of(6, board_frames, "");
  for (std::size_t i = 0; i < all.size(); i += 41) {
    const PoseConvention& boards = all[i];
    const HandEye found = calibrated(tables_of(run, kuka, boards));
    EXPECT_EQ(name_of(found.boards, board_frames), name_of(boards, board_frames));
    EXPECT_EQ(name_of(found.robot, robot_frames), name_of(kuka, robot_frames));
  }
}

HandEyeError mean_error(const std::vector<PosePair>& pairs, const HandEyePoses& poses) {
  HandEyeError mean;
  for (const PosePair& pair : pairs) {
    const PoseError error = error_of(pair, poses, EyePlace::in_hand);
    mean.rotation += error.head<3>().norm() / static_cast<double>(pairs.size());
    mean.translation += error.tail<3>().norm() / static_cast<double>(pairs.size());
  }
  return mean;
}

/// The usual joint refinement, by Newton's method from the truth: rotation and translation of all
/// poses weighted by their mean errors, whatever their directions.
HandEyePoses joint_optimum(const RobotRun& run) {
  HandEyePoses poses = run.truth;
  for (int step = 0; step < 10; ++step) {
    const HandEyeError mean = mean_error(run.pairs, poses);
    PoseError weight;
    weight << Eigen::Vector3d::Constant(std::pow(mean.rotation, -2)),
        Eigen::Vector3d::Constant(std::pow(mean.translation, -2));

    Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
    Eigen::Matrix<double, 12, 1> gradient = Eigen::Matrix<double, 12, 1>::Zero();
    for (const PosePair& pair : run.pairs) {
      const PairDerivatives by = derivatives_of(pair, poses, EyePlace::in_hand);
      normal += by.transpose() * weight.asDiagonal() * by;
      gradient += by.transpose() * weight.cwiseProduct(error_of(pair, poses, EyePlace::in_hand));
    }

    const Eigen::Matrix<double, 12, 1> change = -normal.ldlt().solve(gradient);
    poses.camera.linear() *= rotation_of_vector(change.head<3>());
    poses.camera.translation() += change.segment<3>(3);
    poses.board.linear() *= rotation_of_vector(change.segment<3>(6));
    poses.board.translation() += change.tail<3>();
  }
  return poses;
}

/// Forty poses that scatter like a KUKA's with a structured-light camera.
TEST(HandEye, MeanErrorIsThatOfTheJointOptimum) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const RobotRun run = moved_robot(
        {.poses = 40, .rotation_error = 0.05 * degree, .translation_error = 0.5, .seed = seed});
    const HandEye found = calibrated(tables_of(run));

    const HandEyeError best = mean_error(run.pairs, joint_optimum(run));
    EXPECT_LT(found.mean.translation, 1.05 * best.translation) << seed;
    EXPECT_LT(found.mean.rotation, 1.05 * best.rotation) << seed;
    EXPECT_NEAR(found.mean.translation, 1, 0.4);
  }
}

TEST(HandEye, NamesAMistypedNumber) {
  Tables tables = tables_of(moved_robot({.seed = 4}));
  const double right = tables.robot.rows[6][1];
  tables.robot.rows[6][1] += 10;
  const HandEye found = calibrated(tables);
  EXPECT_FALSE(found.each[6].used);
  EXPECT_NE(found.each[6].reason.find("its y is"), std::string::npos) << found.each[6].reason;
  const std::size_t fits = found.each[6].reason.find("about ");
  ASSERT_NE(fits, std::string::npos) << found.each[6].reason;
  EXPECT_NEAR(std::stod(found.each[6].reason.substr(fits + 6)), right, 1);
  EXPECT_EQ(std::ranges::count(found.each, true, &HandEyePose::used), 14);
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings[0].kind, FindingKind::odd_pose);

  // Two numbers are no slip of one.
  tables.robot.rows[6][0] += 10;
  EXPECT_EQ(calibrated(tables).each[6].reason, "mistyped, moved, or a board found wrongly");
}

// Of 1.5 mm, or half a degree about the board's origin: over six deviations.
TEST(HandEye, LeavesOutAPoseThatIsOff) {
  RobotRun run = moved_robot({.seed = 4});
  run.pairs[6].robot.translation().y() += 1.5;
  run.pairs[9].board.rotate(Eigen::AngleAxisd(0.5 * degree, Eigen::Vector3d::UnitZ()));
  const HandEye found = calibrated(tables_of(run));
  for (std::size_t i = 0; i < found.each.size(); ++i) {
    EXPECT_EQ(found.each[i].used, i != 6 && i != 9) << i;
  }
}

// Small errors of the robot's pose, about and along the axes of the tool, by differences.
TEST(HandEye, CovarianceIsThatOfTheRobotsErrors) {
  for (const EyePlace place : {EyePlace::in_hand, EyePlace::to_hand}) {
    const RobotRun run = moved_robot({.place = place, .poses = 3});
    const PosePair& pair = run.pairs[1];
    constexpr double step = 1e-5, turn = 1e-3, move = 0.2;

    Eigen::Matrix<double, 6, 6> effect;
    for (int i = 0; i < 6; ++i) {
      PosePair other = pair;
      const Eigen::Vector3d by = step * Eigen::Vector3d::Unit(i % 3);
      if (i < 3) other.robot.rotate(rotation_of_vector(by));
      if (i >= 3) other.robot.translate(by);
      effect.col(i) = (error_of(other, run.truth, place) - error_of(pair, run.truth, place)) / step;
    }
    PoseError variances, lengths;
    variances << Eigen::Vector3d::Constant(turn * turn), Eigen::Vector3d::Constant(move * move);
    lengths << Eigen::Vector3d::Constant(500), Eigen::Vector3d::Ones();  // mm for a turn by 1
    const Eigen::Matrix<double, 6, 6> expected =
        effect * variances.asDiagonal() * effect.transpose();
    const Eigen::Matrix<double, 6, 6> found =
        covariance_of(pair, run.truth, place, {.robot_rotation = turn, .robot_translation = move});
    const Eigen::Matrix<double, 6, 6> off =
        lengths.asDiagonal() * (found - expected) * lengths.asDiagonal();
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.01);  // of about 0.25 mm^2
  }
}

TEST(HandEye, SaysWhichTurnIsMissing) {
  // Turns about the tool's z alone.
  RobotRun run = moved_robot({.tilt = 0, .seed = 2});
  const PosePair first = run.pairs.front();
  for (std::size_t i = 0; i < run.pairs.size(); ++i) {
    const Eigen::AngleAxisd turn(0.1 * static_cast<double>(i), Eigen::Vector3d::UnitZ());
    run.pairs[i].robot = first.robot * turn;
    run.pairs[i].board =
        run.truth.camera.inverse() * run.pairs[i].robot.inverse() * run.truth.board;
  }
  const std::string message = message_of(tables_of(run), {.robot = "kuka", .boards = ""});
  EXPECT_NE(message.find("insufficient motion"), std::string::npos) << message;
  EXPECT_NE(message.find("about the tool's "), std::string::npos) << message;
  EXPECT_EQ(message.find("about the tool's z"), std::string::npos) << message;
  EXPECT_NE(message_of(tables_of(run)).find("insufficient motion"), std::string::npos);
}

TEST(HandEye, WarnsOfInversePosesWhichTheOtherPlaceWouldExplain) {
  const Tables tables = tables_of(moved_robot({.seed = 3}));
  const HandEye found = calibrated(tables, EyePlace::to_hand);
  EXPECT_TRUE(found.robot.inverse);
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_NE(text_of(found.findings[0]).find("`eye in-hand`"), std::string::npos);
  EXPECT_TRUE(calibrated(tables).findings.empty());
}

TEST(HandEye, TellsTwoConventionsThatFitAlike) {
  // Without a side on which the board must be, both directions inverted only exchange the roles.
  RobotRun run = moved_robot({.seed = 3});
  for (PosePair& pair : run.pairs) {
    pair.board = pair.board * Eigen::AngleAxisd(180 * degree, Eigen::Vector3d::UnitX());
  }
  const std::string message = message_of(tables_of(run));
  EXPECT_NE(message.find("two conventions fit equally well"), std::string::npos) << message;
  EXPECT_EQ(message_of(tables_of(run), {.robot = "", .boards = "board to camera"}), "");
}

TEST(HandEye, RefusesPosesThatDoNotBelongTogether) {
  const Tables tables = tables_of(moved_robot({.seed = 1})),
               other = tables_of(moved_robot({.seed = 2}));
  EXPECT_NE(message_of({tables.robot, other.boards}).find("no convention fits"), std::string::npos);
  EXPECT_NE(message_of(tables, {.robot = "kuka, m", .boards = ""}).find("30 mm and 30 m"),
            std::string::npos);
  EXPECT_NE(message_of(tables, {.robot = "m", .boards = "mm"}).find("no convention fits"),
            std::string::npos);

  Tables fewer = tables;
  fewer.boards.rows.pop_back();
  EXPECT_NE(message_of(fewer).find("15 robot poses and 14 boards"), std::string::npos);
}

TEST(HandEye, FindsABoardOfAnotherSize) {
  RobotRun run = moved_robot({.seed = 5});
  for (PosePair& pair : run.pairs) pair.board.translation() /= 1.02;
  const HandEye found = calibrated(tables_of(run));
  EXPECT_NEAR(found.scale, 1.02, 0.003);
  EXPECT_TRUE(std::ranges::count(found.findings, FindingKind::wrong_print_size, &Finding::kind));
}

// A robot that errs by millimetres is no ruler.
TEST(HandEye, FindsNoOtherSizeByARobotThatScatters) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const HandEye found = calibrated(tables_of(
        moved_robot({.rotation_error = 0.1 * degree, .translation_error = 3, .seed = seed})));
    EXPECT_FALSE(std::ranges::count(found.findings, FindingKind::wrong_print_size, &Finding::kind))
        << found.scale << " +- " << found.scale_deviation;
  }
}

TEST(HandEye, TellsWhatMorePosesGive) {
  const HandEye few = calibrated(tables_of(moved_robot({.poses = 8, .seed = 6})));
  ASSERT_EQ(few.more.size(), 4U);
  EXPECT_EQ(few.more[0].which, "8 more like these");
  for (const MorePoses& more : few.more) {
    EXPECT_LT(more.translation, few.translation_deviation.norm());
  }

  // Twice as many halve the variance of the fit; the deviation is at least that.
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const HandEye found = calibrated(tables_of(moved_robot({.poses = 20, .seed = seed})));
    EXPECT_LT(found.more[0].translation, 1.001 * found.translation_deviation.norm() / std::sqrt(2));
  }
}

TEST(HandEye, TakesPosesByName) {
  Tables tables = tables_of(moved_robot({.seed = 8}));
  for (int i = 0; i < 15; ++i) tables.robot.names.push_back("pose" + std::to_string(i));
  tables.boards.names = tables.robot.names;
  std::ranges::reverse(tables.boards.names);
  std::ranges::reverse(tables.boards.rows);
  tables.boards.names.pop_back();
  tables.boards.rows.pop_back();
  EXPECT_EQ(calibrated(tables).each.size(), 14U);

  tables.boards.names.assign(14, "other");
  EXPECT_NE(message_of(tables).find("no name in common"), std::string::npos);
}

TEST(HandEye, NamesTheRowsWithoutAPartner) {
  Tables tables = tables_of(moved_robot({.seed = 8}));
  for (int i = 0; i < 15; ++i) {
    tables.robot.names.push_back("p" + std::to_string(i));
    tables.boards.names.push_back(i < 8 ? "p" + std::to_string(i) : "b" + std::to_string(i));
  }
  tables.boards.names[14] = "p14";

  const HandEye found = calibrated(tables);
  EXPECT_EQ(found.each.size(), 9U);
  std::vector<std::string> texts;
  for (const Finding& finding : found.findings) texts.push_back(finding.what);
  EXPECT_TRUE(std::ranges::count(
      texts, "6 robot poses have no board of the same name: p8, p9, p10, p11, p12, ..."))
      << testing::PrintToString(texts);
  EXPECT_TRUE(std::ranges::count(
      texts, "6 boards have no robot pose of the same name: b8, b9, b10, b11, b12, ..."));
}

TEST(HandEye, LeavesOutAPoseWithoutABoard) {
  Tables tables = tables_of(moved_robot({.seed = 9}));
  std::ranges::fill(tables.boards.rows[2], nan);
  const HandEye found = calibrated(tables);
  EXPECT_FALSE(found.each[2].used);
  EXPECT_FALSE(found.each[2].error);
}

TEST(HandEyeReport, LeavesOutErrorsThatAreNotMeasured) {
  HandEye found = calibrated(tables_of(moved_robot({.seed = 8})));
  EXPECT_NE(text_of(found).find("held out"), std::string::npos);
  found.mean_left_out = {nan, nan};
  EXPECT_EQ(text_of(found).find("held out"), std::string::npos);
  EXPECT_EQ(text_of(found).find("nan"), std::string::npos) << text_of(found);
}

}  // namespace slipstream::hand_eye_test
