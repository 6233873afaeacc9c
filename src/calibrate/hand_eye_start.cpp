#include "calibrate/hand_eye_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

using Poses = std::vector<Eigen::Isometry3d>;
using Subset = std::vector<std::size_t>;

/// A table's rows in one notation, without unit and direction.
struct ReadRows {
  RotationNotation notation;
  Poses poses;
  std::vector<double> angles;  ///< between pairs of poses, rad
};

/// The moments that all notations can read, at most `most` of them, spread evenly.
struct Moments {
  PoseTable robot, boards;
};

/// Pairs of poses whose rotation angles are compared, at most about a thousand.
template <class Use>
void for_each_pair(std::size_t count, const Use& use) {
  constexpr std::size_t most = 1000;
  const std::size_t step = std::max<std::size_t>(1, count * (count - 1) / 2 / most);
  std::size_t pair = 0;
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (pair++ % step == 0) use(i, j);
    }
  }
}

/// The table in each notation of the conventions that can read all its rows.
std::vector<ReadRows> read_in_all(const PoseTable& table,
                                  std::span<const PoseConvention> conventions) {
  std::vector<ReadRows> all;
  for (const PoseConvention& convention : conventions) {
    const std::string name = name_of(convention.rotation);
    if (std::ranges::any_of(all,
                            [&](const ReadRows& rows) { return name_of(rows.notation) == name; })) {
      continue;
    }

    ReadRows rows{.notation = convention.rotation, .poses = {}, .angles = {}};
    for (const auto& pose : poses_of(table, convention.rotation)) {
      if (pose) rows.poses.push_back(*pose);
    }
    if (rows.poses.size() < table.rows.size()) continue;

    for_each_pair(rows.poses.size(), [&](std::size_t i, std::size_t j) {
      rows.angles.push_back(angle_between(rows.poses[i].linear(), rows.poses[j].linear()));
    });
    all.push_back(std::move(rows));
  }
  return all;
}

/// The camera's carrier in the board's carrier, and the board in the camera, at each moment: with
/// the camera X on its carrier and the board Y on its own, carrier X board = Y.
struct Chain {
  Poses carriers, boards;

  [[nodiscard]] std::size_t size() const { return carriers.size(); }
};

/// The rotations of camera and board from some moments: the relative turns of the carrier are those
/// of the board, seen from the camera (Park and Martin 1994).
void solve_rotations(const Chain& chain, const Subset& subset, HandEyePoses& poses) {
  // The axis of a turn of about 180 degrees may have either sign.
  constexpr double most_turn = 160 * degree;

  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  for (const std::size_t i : subset) {
    for (const std::size_t j : subset) {
      if (j >= i) continue;
      const Eigen::Vector3d carrier =
          vector_of(chain.carriers[j].linear().transpose() * chain.carriers[i].linear());
      const Eigen::Vector3d board =
          vector_of(chain.boards[j].linear() * chain.boards[i].linear().transpose());
      if (carrier.norm() < most_turn) turns += carrier * board.transpose();
    }
  }
  poses.camera.linear() = nearest_rotation(turns);

  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::size_t i : subset) {
    sum += chain.carriers[i].linear() * poses.camera.linear() * chain.boards[i].linear();
  }
  poses.board.linear() = nearest_rotation(sum);
}

/// The translations of both, by least squares, for known rotations.
void solve_translations(const Chain& chain, const Subset& subset, HandEyePoses& poses) {
  const auto rows = static_cast<Eigen::Index>(3 * subset.size());
  Eigen::Matrix<double, Eigen::Dynamic, 6> by(rows, 6);
  Eigen::VectorXd values(rows);

  for (std::size_t k = 0; k < subset.size(); ++k) {
    const std::size_t i = subset[k];
    const Eigen::Matrix3d carrier = chain.carriers[i].linear();
    const auto row = static_cast<Eigen::Index>(3 * k);
    by.block<3, 3>(row, 0) = carrier;
    by.block<3, 3>(row, 3) = -Eigen::Matrix3d::Identity();
    values.segment<3>(row) = -chain.carriers[i].translation() -
                             carrier * (poses.camera.linear() * chain.boards[i].translation());
  }

  const Eigen::Matrix<double, 6, 1> solution = least_squares(by, values).X;
  poses.camera.translation() = solution.head<3>();
  poses.board.translation() = solution.tail<3>();
}

/// Errors of all moments, rad; with the translations' over the distance of the board.
std::vector<double> errors_of(const Chain& chain, const HandEyePoses& poses,
                              std::optional<double> distance) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Eigen::Isometry3d board = chain.carriers[i] * poses.camera * chain.boards[i];
    const double turn = angle_between(board.linear(), poses.board.linear());
    const double move =
        distance ? (board.translation() - poses.board.translation()).norm() / *distance : 0;
    errors.push_back(std::hypot(turn, move));
  }
  return errors;
}

/// The half of the moments with the smallest errors, at least three.
Subset best_half(const std::vector<double>& errors) {
  Subset order(errors.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return errors[i]; });
  order.resize(std::max<std::size_t>(3, (errors.size() + 1) / 2));
  return order;
}

/// Random threes of the moments, the same in every run.
std::vector<Subset> threes_of(std::size_t count) {
  constexpr int tries = 60;
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> any(0, count - 1);

  std::vector<Subset> threes{{0, 1, 2}};
  while (count > 3 && threes.size() < tries) {
    const Subset three{any(random), any(random), any(random)};
    if (three[0] != three[1] && three[1] != three[2] && three[0] != three[2]) {
      threes.push_back(three);
    }
  }
  return threes;
}

/// The poses by `solve` from the three moments that most others agree with, then from the half that
/// fits best. Returns the median error.
template <class Solve>
double solve_robustly(const Chain& chain, const std::vector<Subset>& threes,
                      std::optional<double> distance, HandEyePoses& poses, const Solve& solve) {
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](const Subset& subset) {
    HandEyePoses tried = poses;
    solve(chain, subset, tried);
    const double error = median(errors_of(chain, tried, distance));
    if (!(error < least)) return;
    least = error;
    poses = tried;
  };

  for (const Subset& three : threes) attempt(three);

  constexpr int refinements = 3;
  for (int i = 0; i < refinements; ++i) attempt(best_half(errors_of(chain, poses, distance)));
  return least;
}

/// The rows in the direction and the unit of a convention.
Poses poses_in(const ReadRows& rows, double unit, bool inverse) {
  Poses poses = rows.poses;
  for (Eigen::Isometry3d& pose : poses) {
    pose.translation() *= unit;
    if (inverse) pose = pose.inverse();
  }
  return poses;
}

/// Pairs of notations whose relative turns have the same angles, best first. These do not depend on
/// the unknown poses, nor on directions, units or the place of the camera.
struct NotationPair {
  const ReadRows* robot;
  const ReadRows* boards;
  double misfit;
};

std::vector<NotationPair> agreeing_notations(const std::vector<ReadRows>& robot,
                                             const std::vector<ReadRows>& boards) {
  std::vector<NotationPair> pairs;
  for (const ReadRows& of_robot : robot) {
    for (const ReadRows& of_boards : boards) {
      std::vector<double> differences;
      for (std::size_t i = 0; i < of_robot.angles.size(); ++i) {
        differences.push_back(std::abs(of_robot.angles[i] - of_boards.angles[i]));
      }
      pairs.push_back({&of_robot, &of_boards, median(std::move(differences))});
    }
  }
  std::ranges::stable_sort(pairs, {}, &NotationPair::misfit);

  // Small turns agree in all orders up to their squares, so the limit is wide.
  constexpr double least_difference = 0.5 * degree;
  constexpr std::size_t most = 100;
  const double limit =
      pairs.empty() ? 0
                    : std::max(4 * pairs.front().misfit, pairs.front().misfit + least_difference);
  std::erase_if(pairs, [&](const NotationPair& pair) { return pair.misfit > limit; });
  pairs.resize(std::min(pairs.size(), most));
  return pairs;
}

/// The units and directions that the conventions with this notation have.
std::vector<PoseConvention> with_notation(std::span<const PoseConvention> conventions,
                                          const RotationNotation& notation) {
  std::vector<PoseConvention> some;
  for (const PoseConvention& convention : conventions) {
    if (name_of(convention.rotation) == name_of(notation)) some.push_back(convention);
  }
  return some;
}

/// Median distance of the board from the camera.
double distance_of(const Poses& boards) {
  const double distance =
      median_of(boards, [](const Eigen::Isometry3d& board) { return board.translation().norm(); });
  return std::max(distance, 1e-9);
}

/// Median depth of the board in the camera's frame.
double depth_of(const Poses& boards) {
  return median_of(boards, [](const Eigen::Isometry3d& board) { return board.translation().z(); });
}

/// The closed form with one pair of conventions; nullopt if its rotations fit far worse than
/// `best_rotation`, which it lowers.
std::optional<HandEyeStart> start_with(const NotationPair& pair, const PoseConvention& robot,
                                       const PoseConvention& board, EyePlace place,
                                       const std::vector<Subset>& threes, double& best_rotation) {
  const bool inverted = robot.inverse != (place == EyePlace::to_hand);
  Chain chain{poses_in(*pair.robot, robot.unit, inverted),
              poses_in(*pair.boards, board.unit, board.inverse)};

  HandEyeStart start{.robot = robot, .board = board, .poses = {}};
  const double turn = solve_robustly(chain, threes, std::nullopt, start.poses, solve_rotations);
  constexpr double hopeless = 20, harmless = 0.5 * degree;
  best_rotation = std::min(best_rotation, turn);
  if (turn > hopeless * best_rotation + harmless) return std::nullopt;

  start.misfit =
      solve_robustly(chain, threes, distance_of(chain.boards), start.poses, solve_translations);
  return start;
}

bool has_one_unit(std::span<const PoseConvention> conventions) {
  return std::ranges::all_of(conventions, [&](const PoseConvention& convention) {
    return convention.unit == conventions.front().unit;
  });
}

/// The boards' poses as a result reads them.
Poses boards_of(const HandEyeStart& start, const std::vector<ReadRows>& board_rows) {
  const auto rows = std::ranges::find_if(board_rows, [&](const ReadRows& of) {
    return name_of(of.notation) == name_of(start.board.rotation);
  });
  return poses_in(*rows, start.board.unit, start.board.inverse);
}

/// Metres and millimetres of both tables only scale the result, and both directions inverted only
/// exchange camera and board. So this takes the results whose board is in front of the camera, at a
/// usual distance.
void keep_plausible(std::vector<HandEyeStart>& starts, const std::vector<ReadRows>& board_rows,
                    bool known_units) {
  std::erase_if(starts, [&](const HandEyeStart& start) {
    constexpr double nearest = 30, farthest = 30000;  // mm
    const Poses poses = boards_of(start, board_rows);
    const double distance = distance_of(poses);
    const bool near = known_units || (distance >= nearest && distance <= farthest);
    return !near || depth_of(poses) <= 0;
  });

  throw_if(
      starts.empty(),
      "the poses fit only with the board behind the camera, or not between 30 mm and 30 m away "
      "from it; check where the camera is, and units and directions in `robot_convention` and "
      "`board_convention`");
}

/// Whether both give practically the same pose of the camera.
bool is_same_result(const HandEyeStart& one, const HandEyeStart& other, double distance) {
  constexpr double same = 1e-3;  // rad; of the board's distance
  const Eigen::Isometry3d &first = one.poses.camera, &second = other.poses.camera;
  return angle_between(first.linear(), second.linear()) < same &&
         (first.translation() - second.translation()).norm() < same * distance;
}

/// The readable rows of both tables; of many rows some, to keep the search short.
Moments moments_to_search(const PoseTable& robot, std::span<const PoseConvention> robot_conventions,
                          const PoseTable& boards,
                          std::span<const PoseConvention> board_conventions) {
  constexpr std::size_t most = 60;

  // A row counts if any notation reads it: a mistyped quaternion is none.
  const auto readable = [](const std::vector<double>& row,
                           std::span<const PoseConvention> conventions) {
    const PoseTable single{{""}, {row}};
    return std::ranges::any_of(conventions, [&](const PoseConvention& convention) {
      return poses_of(single, convention).front().has_value();
    });
  };

  Moments all;
  for (std::size_t i = 0; i < robot.rows.size(); ++i) {
    if (!readable(robot.rows[i], robot_conventions)) continue;
    if (!readable(boards.rows[i], board_conventions)) continue;
    all.robot.rows.push_back(robot.rows[i]);
    all.boards.rows.push_back(boards.rows[i]);
  }
  throw_if(all.robot.rows.size() < 3, "{} poses can be used; hand-eye calibration needs at least 3",
           all.robot.rows.size());

  Moments some;
  const std::size_t step = (all.robot.rows.size() + most - 1) / most;
  for (std::size_t i = 0; i < all.robot.rows.size(); i += step) {
    some.robot.rows.push_back(all.robot.rows[i]);
    some.boards.rows.push_back(all.boards.rows[i]);
  }
  return some;
}

}  // namespace

std::vector<HandEyeStart> fitting_conventions(const PoseTable& robot,
                                              std::span<const PoseConvention> robot_conventions,
                                              const PoseTable& boards,
                                              std::span<const PoseConvention> board_conventions,
                                              EyePlace place) {
  // 1. The numbers in all notations, and those of both tables that can belong together.
  const Moments moments = moments_to_search(robot, robot_conventions, boards, board_conventions);
  const std::vector<ReadRows> robot_rows = read_in_all(moments.robot, robot_conventions);
  const std::vector<ReadRows> board_rows = read_in_all(moments.boards, board_conventions);
  const std::vector<Subset> threes = threes_of(moments.robot.rows.size());

  // 2. The closed form with each of their units and directions.
  std::vector<HandEyeStart> starts;
  double best_rotation = std::numeric_limits<double>::infinity();
  for (const NotationPair& pair : agreeing_notations(robot_rows, board_rows)) {
    for (const PoseConvention& of_robot : with_notation(robot_conventions, pair.robot->notation)) {
      for (const PoseConvention& of_board :
           with_notation(board_conventions, pair.boards->notation)) {
        const auto start = start_with(pair, of_robot, of_board, place, threes, best_rotation);
        if (start) starts.push_back(*start);
      }
    }
  }
  throw_if(starts.empty(), "no convention reads all robot poses: likely a damaged row");

  // 3. Those about as good as the best.
  const double least = std::ranges::min_element(starts, {}, &HandEyeStart::misfit)->misfit;
  constexpr double alike = 3, rounding = 1e-6;
  std::erase_if(starts,
                [&](const HandEyeStart& start) { return start.misfit > alike * least + rounding; });

  keep_plausible(starts, board_rows,
                 has_one_unit(robot_conventions) && has_one_unit(board_conventions));

  // 4. Best first, without those that give the same result.
  std::ranges::stable_sort(starts, {}, &HandEyeStart::misfit);
  std::vector<HandEyeStart> different;
  for (const HandEyeStart& start : starts) {
    if (std::ranges::none_of(different, [&](const HandEyeStart& other) {
          return is_same_result(start, other, distance_of(boards_of(start, board_rows)));
        })) {
      different.push_back(start);
    }
  }
  return different;
}

}  // namespace slipstream
