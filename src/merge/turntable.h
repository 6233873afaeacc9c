#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace slipstream {

/// How the second of two views lies to the first, as registration or boards found it.
struct PairPose {
  std::size_t first = 0, second = 0;                       ///< indices of the views
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< second to first view's frame
  /// Information about a small turn (rad) and shift (mm) of the second view about `centre`, in the
  /// first view's frame.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// A turntable in front of a camera that stands still: the object turns about one axis from view
/// to view, by the right-hand rule.
struct Turntable {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< of the axis, unit length, camera frame
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< on the axis, nearest to the object, mm
  std::vector<double> angles{};                          ///< of each view, rad; the first is 0
  std::optional<double> step{};                          ///< rad; nullopt if the steps differ

  // Standard deviations; infinite if the views leave one of the parameters open.
  double direction_sigma = 0;  ///< of its least known tilt, rad
  double point_sigma = 0;      ///< of its least known shift across the axis, mm
  double step_sigma = 0;       ///< rad; of the least known angle if the steps differ
};

/// The motion of the second view's points into the first view's frame.
Eigen::Isometry3d pose_on(const Turntable& table, std::size_t first, std::size_t second);

/// Derivatives of the turn and shift of a pair's second view about `centre` by the parameters: the
/// direction's tilt to two sides, the point's shift to these, then the step, unless it is held, or
/// the angles of all views but the first.
Eigen::Matrix<double, 6, Eigen::Dynamic> motion_by_parameters(const Turntable& table,
                                                              const PairPose& pair,
                                                              const Eigen::Vector3d& centre,
                                                              bool hold_step);

/// A view that does not lie as the turntable turned it.
struct MovedView {
  std::size_t view = 0;
  /// Whether all later views lie like it: the object was moved before it. Otherwise only this one.
  bool stays = false;
  double turn = 0;   ///< rad, from its place on the turntable
  double shift = 0;  ///< mm, at its middle
};

/// A turntable found from pairs of views.
struct TurntableFit {
  Turntable table{};
  std::vector<Eigen::Isometry3d> poses{};  ///< of each view's points, to the first view's frame
  std::vector<double> misfits{};           ///< of each pair, in the standard deviations of most
  std::vector<bool> agrees{};              ///< whether each pair agrees with the turntable
  double scale = 1;  ///< of the deviations of most pairs, in their standard deviations
  std::optional<MovedView> moved{};
};

struct TurntableSettings {
  std::optional<double> step{};  ///< rad, if known: by the right-hand rule about the axis
  bool equal_steps = true;       ///< false: each view has an angle of its own
};

/// Finds axis and angles from the poses of pairs; most must be right. Names the view, if
/// any, that explains the others. With `equal_steps` it still gives each view its own angle if the
/// steps clearly differ. Throws Error if the views hardly turn, do not turn about one axis, or are
/// not connected by pairs.
TurntableFit fit_turntable(std::size_t views, std::span<const PairPose> pairs,
                           const TurntableSettings& settings = {});

/// Normal equations of the distances between two views' surfaces for a small turn (rad) and shift
/// (mm) of the second about `centre`, in the first view's frame, from a pose.
struct PairEquations {
  Eigen::Matrix<double, 6, 6> squares = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// The equations of pair `k` with its second view at `pose`.
using EquationsOfPair = std::function<PairEquations(std::size_t k, const Eigen::Isometry3d& pose)>;

/// Moves axis and angles to where all pairs together fit best, with the axis common to all views.
/// `rounds`: of new equations. Sets the standard deviations from the information.
Turntable refined_turntable(Turntable table, std::span<const PairPose> pairs,
                            const EquationsOfPair& equations, int rounds, bool hold_step = false);

}  // namespace slipstream
