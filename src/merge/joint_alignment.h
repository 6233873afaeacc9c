#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "merge/pair_alignment.h"

namespace slipstream {

/// Two views that share surface.
struct ViewLink {
  std::size_t first = 0, second = 0;  ///< indices of the views; first < second
  /// As found for the pair alone; the overlap, distances and misfits at the joint poses.
  PairAlignment alignment{};
  bool closes_loop = false;  ///< the views were connected without it
  double loop_error = 0;     ///< mm by which it contradicts the joint poses, at the second's points
};

/// Poses of several views in one frame.
struct JointAlignment {
  /// Each view's frame to the frame of the first view that is joined; nullopt if it is not joined.
  std::vector<std::optional<Eigen::Isometry3d>> poses{};
  std::vector<std::string> reasons{};  ///< why each view is not joined; empty if it is
  std::vector<ViewLink> links{};       ///< joined pairs
  std::vector<ViewLink> refused{};  ///< pairs that were tried, and links that the others contradict
  /// Pairs, joined or refused, of joined views that do not fit at the joint poses: their surfaces
  /// differ, or a camera would have seen through one. The alignment is the one at these poses.
  std::vector<ViewLink> misfits{};

  /// Errors of the links that close a loop, before the joint refinement: RMS at the views' points,
  /// mm, and of the turns, degrees. nullopt without a loop.
  std::optional<double> loop_error{}, loop_turn{};

  [[nodiscard]] std::size_t joined() const;
};

struct JointSettings {
  AlignmentSettings pairs{};
  /// Poses about which the views lie, from files or a turntable; to any common frame. Empty, or one
  /// for each view.
  std::vector<std::optional<Eigen::Isometry3d>> starts{};
  int rounds = 6;                                ///< of the joint refinement
  std::function<void(double share)> progress{};  ///< 0 to 1; may be empty
};

/// Joins views: pairs without a start, neighbours in the list first, or pairs from one; then all
/// pairs that overlap, then all poses at once by the distances of all common surfaces, weighted by
/// their noise. Links that contradict the others are dropped. Never joins a view that only a
/// refused pair connects.
JointAlignment join_views(const std::vector<PreparedView>& views,
                          const JointSettings& settings = {});

}  // namespace slipstream
