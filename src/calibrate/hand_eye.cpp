#include "calibrate/hand_eye.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "calibrate/hand_eye_consensus.h"
#include "calibrate/hand_eye_motion.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

/// The readable moments: their pairs, and the index of each in the tables.
struct ReadMoments {
  std::vector<PosePair> pairs;
  std::vector<std::size_t> rows;
};

ReadMoments read_moments(const PoseTable& robot, const PoseTable& boards,
                         const HandEyeStart& start) {
  const auto robot_poses = poses_of(robot, start.robot);
  const auto board_poses = poses_of(boards, start.board);

  ReadMoments read;
  for (std::size_t i = 0; i < robot_poses.size(); ++i) {
    if (!robot_poses[i] || !board_poses[i]) continue;
    read.pairs.push_back({*robot_poses[i], *board_poses[i]});
    read.rows.push_back(i);
  }
  return read;
}

std::string names_of(const HandEyeStart& start) {
  return fmt::format("robot '{}' with boards '{}'", name_of(start.robot, robot_frames),
                     name_of(start.board, board_frames));
}

/// The convention that fits, if only one does.
HandEyeStart only_start(const PoseTable& robot, const PoseTable& boards,
                        const HandEyeSettings& settings) {
  const auto robot_conventions =
      conventions_of(robot.rows.front().size(), robot_frames, settings.robot);
  const auto board_conventions =
      conventions_of(boards.rows.front().size(), board_frames, settings.boards);
  const std::vector<HandEyeStart> starts =
      fitting_conventions(robot, robot_conventions, boards, board_conventions, settings.place);
  const HandEyeStart& best = starts.front();

  // 1. Without turns about two axes, everything fits, and readings may differ in the axis.
  const TurnSpread spread = turn_spread(read_moments(robot, boards, best).pairs);
  const bool one_axis = std::ranges::all_of(starts, [&](const HandEyeStart& start) {
    return weakest_axis(turn_spread(read_moments(robot, boards, start).pairs)) ==
           weakest_axis(spread);
  });
  throw_if(spread.turns[1] < least_second_turn,
           "insufficient motion: about a second axis the tool turned by {:.2g} degrees only; add "
           "poses turned by 20 degrees or more, both ways, about {}",
           spread.turns[1] / degree,
           one_axis ? fmt::format("the tool's {}", weakest_axis(spread))
                    : "an axis across the one so far");

  // 2. A wrong order of angles misses by tens of degrees, a wrong unit by the whole travel.
  constexpr double largest_misfit = 0.03;  // rad, or of the board's distance
  const bool restricted = !settings.robot.empty() || !settings.boards.empty();
  throw_if(best.misfit > largest_misfit,
           "no convention fits the poses: the best, {}, misses by {:.2g} degrees; check {}that "
           "both lists are in the same order and the camera is {}",
           names_of(best), best.misfit / degree,
           restricted ? "`robot_convention` and `board_convention`, " : "",
           settings.place == EyePlace::in_hand ? "on the tool" : "beside the robot");

  if (starts.size() > 1) {
    throw Error(fmt::format(
        "two conventions fit equally well: {}, and {}; choose one with `robot_convention` and "
        "`board_convention`, or add poses with other turns",
        names_of(starts[0]), names_of(starts[1])));
  }
  return best;
}

/// The likely mistake in a pose that does not fit: another's place, or one wrong number.
std::string likely_mistake(std::size_t pose, const ReadMoments& read, const Used& used,
                           const HandEye& result, const std::vector<std::string>& names) {
  const std::vector<PosePair>& pairs = read.pairs;
  constexpr double near = 0.1;  // of its error

  // 1. Two poses in each other's place.
  const double own = error_of(pairs[pose], result.poses, result.place).tail<3>().norm();
  for (std::size_t other = 0; other < pairs.size(); ++other) {
    if (other == pose || used[other]) continue;
    const auto crossed = [&](std::size_t of_robot, std::size_t of_board) {
      const PosePair pair{pairs[of_robot].robot, pairs[of_board].board};
      return error_of(pair, result.poses, result.place).tail<3>().norm();
    };
    if (crossed(pose, other) < near * own && crossed(other, pose) < near * own) {
      return fmt::format("swapped with pose {}", names[read.rows[other]]);
    }
  }

  // 2. One coordinate of the robot's position, as its table has it.
  Eigen::Isometry3d expected = robot_for(pairs[pose].board, result.poses, result.place);
  Eigen::Isometry3d written = pairs[pose].robot;
  if (result.robot.inverse) {
    expected = expected.inverse();
    written = written.inverse();
  }

  const Eigen::Vector3d off = written.translation() - expected.translation();
  Eigen::Index wrong = 0;
  const double most = off.cwiseAbs().maxCoeff(&wrong);
  const bool others_fit = (off - off[wrong] * Eigen::Vector3d::Unit(wrong)).norm() < near * most;
  const double turn = error_of(pairs[pose], result.poses, result.place).head<3>().norm();

  if (!others_fit || turn > 0.2 * degree) return "mistyped, moved, or a board found wrongly";
  return fmt::format("mistyped: its {} is {:g}, and about {:g} would fit", "xyz"[wrong],
                     written.translation()[wrong] / result.robot.unit,
                     std::round(10 * expected.translation()[wrong]) / 10 / result.robot.unit);
}

/// Size of the boards by the robot's travel: as the translations of the closed form, with one
/// factor more.
void measure_scale(const std::vector<PosePair>& pairs, HandEye& result) {
  const auto rows = static_cast<Eigen::Index>(3 * pairs.size());
  if (rows <= 7) return;

  Eigen::Matrix<double, Eigen::Dynamic, 7> by(rows, 7);
  Eigen::VectorXd values(rows);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Eigen::Isometry3d carrier = pairs[i].robot;
    if (result.place == EyePlace::to_hand) carrier = carrier.inverse();

    const auto row = static_cast<Eigen::Index>(3 * i);
    by.block<3, 3>(row, 0) = carrier.linear();
    by.block<3, 3>(row, 3) = -Eigen::Matrix3d::Identity();
    by.block<3, 1>(row, 6) =
        carrier.linear() * (result.poses.camera.linear() * pairs[i].board.translation());
    values.segment<3>(row) = -carrier.translation();
  }

  const Eigen::Matrix<double, 7, 7> normal = by.transpose() * by;
  const Eigen::Matrix<double, 7, 1> solution = least_squares(by, values).X;
  const double variance = (by * solution - values).squaredNorm() / static_cast<double>(rows - 7);
  result.scale = solution[6];
  result.scale_deviation = std::sqrt(variance * inverse_of(normal)(6, 6));
}

std::vector<Finding> findings_of(const HandEye& result, std::size_t used) {
  std::vector<Finding> findings;

  // 1. Poses that do not fit.
  for (const HandEyePose& pose : result.each) {
    if (pose.used) continue;
    Finding finding{.kind = FindingKind::odd_pose,
                    .what = fmt::format("pose {} was left out", pose.name)};
    if (pose.error) {
      finding.evidence = {{"position error", pose.error->translation, "mm"},
                          {"rotation error", pose.error->rotation / degree, "degrees"}};
    }
    finding.causes = {{CauseKind::moved_board, pose.reason}};
    finding.remedies = {{"correct or remove it, and calibrate again"}};
    findings.push_back(std::move(finding));
  }

  // 2. Too few.
  constexpr std::size_t enough = 8;
  if (used < enough) {
    findings.push_back(
        {.kind = FindingKind::few_poses,
         .what = fmt::format("only {} poses: their scatter is uncertain", used),
         .evidence = {{"poses", static_cast<double>(used), "", static_cast<double>(enough)}},
         .causes = {{CauseKind::few_poses, "too few poses"}},
         .remedies = {{fmt::format("take {} or more", enough)}}});
  }

  // 3. The robot as a ruler.
  constexpr double most_deviations = 5, least = 0.002;
  const double off = result.scale - 1;
  if (std::abs(off) > std::max(most_deviations * result.scale_deviation, least)) {
    findings.push_back(
        {.kind = FindingKind::wrong_print_size,
         .what = "the boards have another size than the robot's travel says",
         .evidence = {{"size error", 100 * off, "%", 100 * least}},
         .causes = {{CauseKind::board_print, "the print, or the camera's focal length"}},
         .remedies = {{fmt::format("measure the print: a `spacing` {:.4g} times as large fits",
                                   result.scale)}}});
  }
  return findings;
}

/// Inverse poses on the tool fit exactly as poses beside the robot do.
std::vector<Finding> findings_of_direction(const HandEye& result, const HandEyeSettings& settings) {
  if (!result.robot.inverse || settings.robot.find(" to ") != settings.robot.npos) return {};
  const bool on_tool = result.place == EyePlace::in_hand;
  return {{.kind = FindingKind::other,
           .what = "the robot's poses are inverse: they lead from its base to its tool",
           .remedies = {{fmt::format("if the robot wrote them as robots do, from tool to base, the "
                                     "camera is {}: use `eye {}`",
                                     on_tool ? "beside the robot" : "on the tool",
                                     on_tool ? "to-hand" : "in-hand")}}}};
}

/// A finding about rows without a partner, by their names.
Finding unmatched_finding(const std::vector<std::string>& names, const char* one, const char* many,
                          const char* partner) {
  constexpr std::size_t most = 5;
  const std::size_t shown = std::min(names.size(), most);
  const std::vector<std::string> first(names.begin(),
                                       names.begin() + static_cast<std::ptrdiff_t>(shown));
  return {.kind = FindingKind::other,
          .what = fmt::format("{} {} no {} of the same name: {}{}", names.size(),
                              names.size() == 1 ? one : many, partner, fmt::join(first, ", "),
                              names.size() > shown ? ", ..." : ""),
          .remedies = {{"correct the names if they belong together, and calibrate again"}}};
}

/// Names that only one of two tables has.
struct UnmatchedNames {
  std::vector<std::string> robot, boards;
};

std::vector<Finding> findings_of_names(const UnmatchedNames& names) {
  std::vector<Finding> findings;
  if (!names.robot.empty()) {
    findings.push_back(
        unmatched_finding(names.robot, "robot pose has", "robot poses have", "board"));
  }
  if (!names.boards.empty()) {
    findings.push_back(unmatched_finding(names.boards, "board has", "boards have", "robot pose"));
  }
  return findings;
}

/// Keeps the rows of both tables that belong together: by name if both have names, otherwise by
/// order. Returns the names of the others. Throws Error if the tables without names are not of one
/// length, or names have none in common.
UnmatchedNames match_moments(PoseTable& robot, PoseTable& boards) {
  for (PoseTable* table : {&robot, &boards}) {
    throw_if(table->rows.empty(), "a list of poses is empty");
  }

  // 1. By order.
  if (robot.names.empty() || boards.names.empty()) {
    throw_if(robot.rows.size() != boards.rows.size(),
             "there are {} robot poses and {} boards; give as many, or both with names",
             robot.rows.size(), boards.rows.size());
    if (robot.names.empty()) robot.names = boards.names;
    for (std::size_t i = robot.names.size(); i < robot.rows.size(); ++i) {
      robot.names.push_back(std::to_string(i + 1));
    }
    boards.names = robot.names;
    return {};
  }

  // 2. By name.
  std::map<std::string, std::vector<double>> boards_by_name;
  for (std::size_t i = 0; i < boards.rows.size(); ++i) {
    boards_by_name[boards.names[i]] = boards.rows[i];
  }

  UnmatchedNames unmatched;
  PoseTable shared_robot, shared_boards;
  for (std::size_t i = 0; i < robot.rows.size(); ++i) {
    const auto board = boards_by_name.find(robot.names[i]);
    if (board == boards_by_name.end()) {
      unmatched.robot.push_back(robot.names[i]);
      continue;
    }

    shared_robot.names.push_back(robot.names[i]);
    shared_robot.rows.push_back(robot.rows[i]);
    shared_boards.rows.push_back(board->second);
  }
  throw_if(shared_robot.rows.empty(),
           "robot poses and boards have no name in common: {} and {}, for example",
           robot.names.front(), boards.names.front());

  const std::set<std::string> of_robot(robot.names.begin(), robot.names.end());
  for (const std::string& name : boards.names) {
    if (!of_robot.contains(name)) unmatched.boards.push_back(name);
  }

  shared_boards.names = shared_robot.names;
  robot = std::move(shared_robot);
  boards = std::move(shared_boards);
  return unmatched;
}

}  // namespace

HandEye calibrate_hand_eye(PoseTable robot, PoseTable boards, const HandEyeSettings& settings) {
  const UnmatchedNames unmatched = match_moments(robot, boards);
  throw_if(robot.rows.size() > most_hand_eye_poses, "{} poses; at most {} are calibrated with",
           robot.rows.size(), most_hand_eye_poses);

  // 1. The meaning of the numbers, and the closed form.
  const HandEyeStart start = only_start(robot, boards, settings);
  const ReadMoments read = read_moments(robot, boards, start);

  // 2. The joint refinement of the poses that agree.
  const EyePlace place = settings.place;
  const RobustFit found = robust_fit(read.pairs, start.poses, place);
  const std::vector<PosePair> pairs = used_pairs(read.pairs, found.used);
  const PoseError deviation = deviation_of(found);

  HandEye result{.place = place,
                 .robot = start.robot,
                 .boards = start.board,
                 .poses = found.fit.poses,
                 .rotation_deviation = deviation.head<3>(),
                 .translation_deviation = deviation.tail<3>(),
                 .scatter = found.fit.scatter,
                 .each = {},
                 .mean = {},
                 .mean_left_out = {nan, nan},
                 .more = more_poses(pairs, found.fit, place),
                 .findings = {}};
  measure_scale(pairs, result);

  // 3. Each pose, used or not.
  for (const std::string& name : robot.names) {
    result.each.push_back(
        {.name = name, .reason = "its numbers are no pose, or no board was found"});
  }
  const auto count = static_cast<double>(pairs.size());
  if (found.left_out) result.mean_left_out = {};
  for (std::size_t i = 0; i < read.pairs.size(); ++i) {
    HandEyePose& pose = result.each[read.rows[i]];
    pose.used = found.used[i];
    pose.error = sizes_of(error_of(read.pairs[i], result.poses, place));
    pose.reason = pose.used ? "" : likely_mistake(i, read, found.used, result, robot.names);
    if (!pose.used) continue;

    result.mean.rotation += pose.error->rotation / count;
    result.mean.translation += pose.error->translation / count;
    if (!found.left_out) continue;
    pose.left_out = sizes_of(*found.left_out->errors[i]);
    result.mean_left_out.rotation += pose.left_out->rotation / count;
    result.mean_left_out.translation += pose.left_out->translation / count;
  }

  // 4. What to know about them.
  result.findings = findings_of(result, pairs.size());
  for (const std::vector<Finding>& more :
       {findings_of_motion(turn_spread(pairs)), findings_of_direction(result, settings),
        findings_of_names(unmatched)}) {
    result.findings.insert(result.findings.end(), more.begin(), more.end());
  }
  return result;
}

}  // namespace slipstream
