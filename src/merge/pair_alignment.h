#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <Eigen/Geometry>

#include "merge/prepared_view.h"
#include "merge/surface_fit.h"

namespace slipstream {

/// Why two views are not joined.
enum class Refusal {
  none,
  no_overlap,    ///< no pose found in which they share enough surface
  sees_through,  ///< a camera would have seen through the other's surface
  misfit,        ///< their surfaces differ by more than the noise
  slides,        ///< the surface is the same when moved: plane, sphere, cylinder, corridor
  repeats,       ///< several poses fit equally well: a repeated or symmetric shape
};

/// "no overlap", "slides", ...
std::string_view name_of(Refusal refusal);

/// How the second of two views lies to the first.
struct PairAlignment {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< second to first view's frame
  Refusal refusal = Refusal::no_overlap;
  std::string reason{};  ///< one sentence; empty if joined

  std::size_t matches = 0;    ///< points with a partner on the other's surface
  double overlap = 0;         ///< share of the points of the view with more overlap
  double contradictions = 0;  ///< share of the compared points through which the other camera saw
  double misfits = 0;         ///< share of the compared points off the other's surface
  /// Whether the contradictions come from a part of the scene that moved between the views while
  /// the rest did not, as an object on a turntable does before a wall.
  bool moved_in_part = false;

  // Distances along the normal, mm.
  double median = 0, percentile_95 = 0, rms = 0;
  double noise = 0;  ///< median expected from the points' standard deviations

  /// Information about a small turn (rad) and shift (mm) of the second view about `centre`, in the
  /// first view's frame, from the noise and the residuals.
  Matrix6 information = Matrix6::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// Standard deviation of the least known motion of the common surface, mm: by noise and, other
  /// than in the information, by the interpolation between points.
  double weakest_sigma = 0;
  /// How much the common surface leans against its least known motion: RMS slope, 0 for a plane.
  double weakest_slope = 0;

  [[nodiscard]] bool joined() const { return refusal == Refusal::none; }
};

struct AlignmentSettings {
  double least_overlap = 0.15;        ///< of the view with more overlap
  double most_contradictions = 0.01;  ///< share of the compared points
  double most_misfits = 0.25;         ///< share of the compared points
  double least_slope = 0.012;         ///< RMS, in the least known direction
  /// Standard deviation of that motion, in units of the view's reach: as a turn, 1.7 of them
  /// are 0.05 degrees.
  double most_uncertain = 0.0005;
  double alike = 0.35;  ///< share of the best score from which a second pose counts
};

/// Finds the pose of the second view without a start: similar features, poses that many of them
/// agree on, then distances from point to plane. Joins only if one pose fits, and refuses all else.
PairAlignment align_views(const PreparedView& first, const PreparedView& second,
                          const AlignmentSettings& settings = {});

/// The same from a start that is about right, within a few cells of the keypoints. Does not look
/// for other poses that fit as well.
PairAlignment refine_alignment(const PreparedView& first, const PreparedView& second,
                               const Eigen::Isometry3d& start,
                               const AlignmentSettings& settings = {});

/// The fit at a pose as it is.
PairAlignment alignment_at(const PreparedView& first, const PreparedView& second,
                           const Eigen::Isometry3d& pose, const AlignmentSettings& settings = {});

/// About the overlap at a pose, from a few points.
double overlap_at(const PreparedView& first, const PreparedView& second,
                  const Eigen::Isometry3d& pose);

/// The same at a pose that may be off by about three cells of the keypoints: the share of the
/// keypoints of the view with fewer of them that have the other's surface near them.
double rough_overlap_at(const PreparedView& first, const PreparedView& second,
                        const Eigen::Isometry3d& pose);

}  // namespace slipstream
