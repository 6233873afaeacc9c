#include "merge/turntable.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "merge/surface_fit.h"

namespace slipstream {
namespace {

using Vector3 = Eigen::Vector3d;

Vector3 turn_of(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// The small motion about `centre` from one pose to another: turn (rad) and shift (mm).
Vector6 motion_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                       const Vector3& centre) {
  const Eigen::Isometry3d motion = to * from.inverse();
  Vector6 step;
  step << turn_of(motion.linear()), motion * centre - centre;
  return step;
}

Eigen::Isometry3d turned(const Turntable& table, double angle) {
  return Eigen::Translation3d(table.point) * Eigen::AngleAxisd(angle, table.direction) *
         Eigen::Translation3d(-table.point);
}

/// Two unit vectors across the axis.
std::pair<Vector3, Vector3> across(const Vector3& direction) {
  const Vector3 first = direction.unitOrthogonal();
  return {first, direction.cross(first)};
}

/// The parameters of a turntable: two of the direction, two of the point, then the step, or the
/// angles of all views but the first.
struct TableParameters {
  explicit TableParameters(const Turntable& table, bool hold_step)
      : angles(table.step ? (hold_step ? 0 : 1) : static_cast<int>(table.angles.size()) - 1) {}

  [[nodiscard]] int count() const { return 4 + angles; }

  /// The table with its parameters changed by `step`.
  [[nodiscard]] Turntable moved(Turntable table, const Eigen::VectorXd& step) const {
    const auto [right, up] = across(table.direction);
    table.point += step[2] * right + step[3] * up;

    const Vector3 tilt = step[0] * right + step[1] * up;
    if (tilt.norm() > 0) {
      table.direction = Eigen::AngleAxisd(tilt.norm(), tilt.normalized()) * table.direction;
    }

    for (std::size_t view = 0; view < table.angles.size(); ++view) {
      if (table.step && angles == 1) {
        table.angles[view] += static_cast<double>(view) * step[4];
      } else if (!table.step && view > 0) {
        table.angles[view] += step[3 + static_cast<Eigen::Index>(view)];
      }
    }
    if (table.step && angles == 1) *table.step += step[4];
    return table;
  }

  int angles;
};

/// Normal equations of all pairs for the parameters.
struct TableEquations {
  Eigen::MatrixXd squares, information;
  Eigen::VectorXd right;
};

TableEquations equations_of_all(const Turntable& table, std::span<const PairPose> pairs,
                                const EquationsOfPair& of_pair, bool hold_step) {
  const int count = TableParameters(table, hold_step).count();
  TableEquations all{Eigen::MatrixXd::Zero(count, count), Eigen::MatrixXd::Zero(count, count),
                     Eigen::VectorXd::Zero(count)};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairEquations pair = of_pair(k, pose_on(table, pairs[k].first, pairs[k].second));
    const auto J = motion_by_parameters(table, pairs[k], pair.centre, hold_step);
    all.squares += J.transpose() * pair.squares * J;
    all.information += J.transpose() * pair.information * J;
    all.right += J.transpose() * pair.right;
  }
  return all;
}

/// Covariance from the information, without the units: rad and mm. nullopt if the information
/// leaves a parameter open.
std::optional<Eigen::MatrixXd> covariance_of(const Eigen::MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const auto inverse = inverse_of_symmetric(scaled, 0);
  if (!inverse) return std::nullopt;
  return scale.asDiagonal() * *inverse * scale.asDiagonal();
}

double largest_deviation(const Eigen::Matrix2d& covariance) {
  return std::sqrt(std::max(0.0, principal_axes(covariance).values[1]));
}

void set_deviations(Turntable& table, const Eigen::MatrixXd& information) {
  const auto covariance = covariance_of(information);
  if (!covariance) {
    table.direction_sigma = table.point_sigma = table.step_sigma =
        std::numeric_limits<double>::infinity();
    return;
  }

  const Eigen::VectorXd variances = covariance->diagonal();
  table.direction_sigma = largest_deviation(covariance->topLeftCorner<2, 2>());
  table.point_sigma = largest_deviation(covariance->block<2, 2>(2, 2));
  table.step_sigma =
      variances.size() > 4 ? std::sqrt(variances.tail(variances.size() - 4).maxCoeff()) : 0;
}

/// Moves the point along the axis to where it is nearest to the pairs' middle.
void centre_point(Turntable& table, std::span<const PairPose> pairs) {
  Vector3 middle = Vector3::Zero();
  for (const PairPose& pair : pairs) middle += pair.centre / static_cast<double>(pairs.size());
  table.point += table.direction.dot(middle - table.point) * table.direction;
}

/// A pair as a turn by itself: axis and angle, right-handed.
struct Screw {
  Vector3 direction, point;
  double angle = 0;  ///< rad, at least 0
};

/// `pose` moves the second view's points back to the first; the screw moves them on.
Screw screw_of(const PairPose& pair) {
  const Eigen::Isometry3d onward = pair.pose.inverse();
  const Eigen::AngleAxisd turn(onward.linear());

  // (I - R) p = t, without the part along the axis.
  const Vector3 t = onward.translation();
  const Vector3 across_axis = t - turn.axis().dot(t) * turn.axis();
  const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - onward.linear();
  return {turn.axis(), least_squares(left, across_axis).X, turn.angle()};
}

/// Angles of all views about an axis, from pair to pair; NaN if views are not connected.
std::vector<double> chained_angles(std::size_t views, std::span<const PairPose> pairs,
                                   const Vector3& direction) {
  std::vector<double> angles(views, nan);
  angles[0] = 0;

  for (std::size_t round = 0; round < views; ++round) {
    for (const PairPose& pair : pairs) {
      const double turn = turn_of(pair.pose.inverse().linear()).dot(direction);
      double &first = angles[pair.first], &second = angles[pair.second];
      if (std::isfinite(first) && !std::isfinite(second)) second = first + turn;
      if (std::isfinite(second) && !std::isfinite(first)) first = second - turn;
    }
  }
  return angles;
}

std::vector<double> equal_angles(std::size_t views, double step) {
  std::vector<double> angles;
  for (std::size_t view = 0; view < views; ++view) {
    angles.push_back(static_cast<double>(view) * step);
  }
  return angles;
}

/// The deviation of a pair's pose from the turntable's, in its standard deviations.
double deviation_of(const Turntable& table, const PairPose& pair) {
  const Vector6 off =
      motion_between(pose_on(table, pair.first, pair.second), pair.pose, pair.centre);
  return std::sqrt(std::max(0.0, off.dot(pair.information * off)) / 6);
}

std::vector<double> deviations_of(const Turntable& table, std::span<const PairPose> pairs) {
  std::vector<double> all;
  for (const PairPose& pair : pairs) all.push_back(deviation_of(table, pair));
  return all;
}

/// Median over the pairs of the error of their turn, as a share of it.
double turn_error(const Turntable& table, std::span<const PairPose> pairs) {
  return median_of(pairs, [&](const PairPose& pair) {
    const Eigen::Matrix3d turn = pose_on(table, pair.first, pair.second).linear();
    return turn_of(pair.pose.linear() * turn.transpose()).norm() /
           std::max(turn_of(pair.pose.linear()).norm(), 1e-9);
  });
}

/// Spread of the deviations of most pairs; at least their standard deviation.
double scale_of(const std::vector<double>& deviations) {
  constexpr double median_of_six = 0.944;  // square root of the median of chi squared, over 6
  return std::max(1.0, median(deviations) / median_of_six);
}

/// The screw of a pair that most others agree with.
Turntable most_agreed(std::size_t views, std::span<const PairPose> pairs,
                      const TurntableSettings& settings) {
  Turntable best;
  double least = std::numeric_limits<double>::infinity();

  for (const PairPose& pair : pairs) {
    Screw screw = screw_of(pair);
    const auto gap = static_cast<double>(pair.second) - static_cast<double>(pair.first);
    const bool backwards = (gap < 0) != (settings.step && *settings.step < 0);
    if (backwards) screw = {-screw.direction, screw.point, -screw.angle};

    Turntable table{.direction = screw.direction, .point = screw.point};
    if (settings.equal_steps) table.step = settings.step.value_or(screw.angle / gap);
    table.angles = table.step ? equal_angles(views, *table.step)
                              : chained_angles(views, pairs, table.direction);

    // Wrong pairs are far off: each costs as much as one at ten times the median.
    std::vector<double> off = deviations_of(table, pairs);
    if (!std::ranges::all_of(off, [](double d) { return std::isfinite(d); })) continue;
    const double limit = 10 * median(off) + 1e-12;
    double cost = median(off);
    for (const double d : off) cost += std::min(d, limit) / static_cast<double>(off.size());
    if (cost < least) best = table;
    least = std::min(least, cost);
  }
  return best;
}

/// Fits the turntable to the poses; far ones lose their weight.
Turntable fitted_to_poses(Turntable table, std::span<const PairPose> pairs, bool hold_step) {
  throw_if(table.angles.empty(), "the views are not all connected by pairs that overlap");
  constexpr int rounds = 30;

  for (int round = 0; round < rounds; ++round) {
    const double scale = scale_of(deviations_of(table, pairs));
    const auto equations = [&](std::size_t k, const Eigen::Isometry3d& pose) {
      const PairPose& pair = pairs[k];
      const double weight = tukey_weight(deviation_of(table, pair) / scale) / (scale * scale);
      const Matrix6 information = weight * pair.information;
      return PairEquations{information, information * motion_between(pose, pair.pose, pair.centre),
                           information, pair.centre};
    };
    table = refined_turntable(table, pairs, equations, 1, hold_step);
  }
  return table;
}

/// Views on the side of a cut, or one view alone, that disagreeing pairs have in common.
bool crosses(const PairPose& pair, std::size_t view, bool stays) {
  if (stays) return (pair.first < view) != (pair.second < view);
  return (pair.first == view) != (pair.second == view);
}

/// The view, or the later views, without which all pairs agree. nullopt if all do, or none explains
/// them.
std::optional<MovedView> moved_view(const TurntableFit& fit, std::span<const PairPose> pairs,
                                    std::size_t views) {
  std::optional<MovedView> best;
  std::size_t fewest_wrong = 0;

  for (const bool stays : {true, false}) {
    for (std::size_t view = stays ? 1 : 0; view < views; ++view) {
      // It explains pairs that cross and disagree, and those that do not cross and agree.
      std::size_t explained = 0, wrong = 0;
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        const bool is_crossing = crosses(pairs[k], view, stays);
        explained += is_crossing && !fit.agrees[k] ? 1 : 0;
        wrong += is_crossing == fit.agrees[k] ? 1 : 0;
      }
      if (explained == 0 || (best && wrong >= fewest_wrong)) continue;
      best = {.view = view, .stays = stays};
      fewest_wrong = wrong;
    }
  }

  std::size_t disagreeing = 0;
  for (const bool agrees : fit.agrees) disagreeing += agrees ? 0 : 1;
  if (!best || fewest_wrong >= disagreeing) return std::nullopt;
  return best;
}

/// The motion of a moved view from its place on the turntable, in the first view's frame.
Eigen::Isometry3d motion_by_hand(MovedView& moved, const Turntable& table,
                                 std::span<const PairPose> pairs) {
  const PairPose* surest = nullptr;
  for (const PairPose& pair : pairs) {
    if (!crosses(pair, moved.view, moved.stays)) continue;
    if (surest == nullptr || pair.information.trace() > surest->information.trace()) surest = &pair;
  }

  // From the place of the moved view by the table to the place by the pair.
  PairPose pair = *surest;
  const bool second_moved = moved.stays ? pair.second > pair.first : pair.second == moved.view;
  if (!second_moved) pair = {pair.second, pair.first, pair.pose.inverse()};
  const Eigen::Isometry3d to_first = pose_on(table, 0, pair.first);
  const Eigen::Isometry3d motion = to_first * pair.pose * pose_on(table, 0, pair.second).inverse();

  moved.turn = turn_of(motion.linear()).norm();
  moved.shift = (motion * table.point - table.point).norm();
  return motion;
}

/// The poses of all views in the first view's frame.
void set_poses(TurntableFit& fit, std::size_t views, std::span<const PairPose> pairs) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (fit.moved) motion = motion_by_hand(*fit.moved, fit.table, pairs);

  for (std::size_t view = 0; view < views; ++view) {
    const bool is_moved =
        fit.moved && (fit.moved->stays ? view >= fit.moved->view : view == fit.moved->view);
    const Eigen::Isometry3d on_table = pose_on(fit.table, 0, view);
    fit.poses.push_back(is_moved ? motion * on_table : on_table);
  }

  // The first view's frame stays where it is, also if it is the one that was moved.
  const Eigen::Isometry3d from_first = fit.poses.front().inverse();
  for (Eigen::Isometry3d& pose : fit.poses) pose = from_first * pose;
}

}  // namespace

Eigen::Isometry3d pose_on(const Turntable& table, std::size_t first, std::size_t second) {
  return turned(table, table.angles[first] - table.angles[second]);
}

Eigen::Matrix<double, 6, Eigen::Dynamic> motion_by_parameters(const Turntable& table,
                                                              const PairPose& pair,
                                                              const Vector3& centre,
                                                              bool hold_step) {
  constexpr double small = 1e-5;  // rad or mm
  const TableParameters parameters(table, hold_step);
  const Eigen::Isometry3d at = pose_on(table, pair.first, pair.second);

  Eigen::Matrix<double, 6, Eigen::Dynamic> all(6, parameters.count());
  for (int i = 0; i < parameters.count(); ++i) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(parameters.count());
    step[i] = small;
    const Turntable moved = parameters.moved(table, step);
    all.col(i) = motion_between(at, pose_on(moved, pair.first, pair.second), centre) / small;
  }
  return all;
}

Turntable refined_turntable(Turntable table, std::span<const PairPose> pairs,
                            const EquationsOfPair& equations, int rounds, bool hold_step) {
  const TableParameters parameters(table, hold_step);
  for (int round = 0; round < rounds; ++round) {
    const TableEquations all = equations_of_all(table, pairs, equations, hold_step);

    // Scale away the units, and solve without directions that nothing determines.
    const Eigen::VectorXd scale =
        all.squares.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * all.squares * scale.asDiagonal();
    const Eigen::VectorXd right = scale.asDiagonal() * all.right;
    const Eigen::VectorXd step = scale.asDiagonal() * least_squares(scaled, right).X;

    table = parameters.moved(std::move(table), step);
    centre_point(table, pairs);
    set_deviations(table, all.information);
  }
  return table;
}

TurntableFit fit_turntable(std::size_t views, std::span<const PairPose> pairs,
                           const TurntableSettings& settings) {
  constexpr double least_turn = 0.2 * degree;
  constexpr double most = 5;                // deviations of most, to agree
  constexpr double most_turn_error = 0.15;  // of a turn
  constexpr double clearly = 3;             // times larger deviations: the steps differ
  throw_if(views < 3 || pairs.size() < 2,
           "{} views and {} pairs of them; an axis needs three views that overlap", views,
           pairs.size());

  // 1. Axis and step on which most pairs agree.
  const bool hold_step = settings.step.has_value();
  TurntableFit fit{.table = fitted_to_poses(most_agreed(views, pairs, settings), pairs, hold_step)};
  fit.scale = scale_of(deviations_of(fit.table, pairs));

  // 2. Each view its own angle, if that fits far better.
  if (!hold_step) {
    const TurntableSettings free{.equal_steps = false};
    const Turntable table = fitted_to_poses(most_agreed(views, pairs, free), pairs, false);
    const double scale = scale_of(deviations_of(table, pairs));
    if (!settings.equal_steps || clearly * scale < fit.scale) {
      fit.table = table;
      fit.scale = scale;
    }
  }

  double largest = 0;
  for (const PairPose& pair : pairs) {
    const double turn = fit.table.angles[pair.second] - fit.table.angles[pair.first];
    largest = std::max(largest, std::abs(turn));
  }
  throw_if(largest < least_turn, "the views hardly turn: {:.2g} degrees", largest / degree);
  throw_if(turn_error(fit.table, pairs) > most_turn_error, "the views do not turn about one axis");

  // 3. Pairs that disagree, and the view that explains them.
  std::size_t agreeing = 0;
  for (const double deviation : deviations_of(fit.table, pairs)) {
    fit.misfits.push_back(deviation / fit.scale);
    fit.agrees.push_back(fit.misfits.back() < most);
    agreeing += fit.agrees.back() ? 1 : 0;
  }
  throw_if(agreeing < 2 || 2 * agreeing < pairs.size(),
           "the views do not turn about one axis: only {} of {} pairs agree", agreeing,
           pairs.size());
  fit.moved = moved_view(fit, pairs, views);
  set_poses(fit, views, pairs);
  return fit;
}

}  // namespace slipstream
