#include "merge/joint_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "base/statistics.h"
#include "merge/groups.h"
#include "merge/joint_poses.h"
#include "merge/overlap.h"

namespace slipstream {
namespace {

/// Pairs to try without a start: neighbours in the list first, then those ever farther apart.
std::vector<std::pair<std::size_t, std::size_t>> pairs_in_order(std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t apart = 1; apart <= count / 2; ++apart) {
    for (std::size_t i = 0; i < count; ++i) {
      // Half the list apart, each pair comes up from both sides.
      if (2 * apart == count && i >= apart) continue;
      const std::size_t k = (i + apart) % count;
      pairs.emplace_back(std::min(i, k), std::max(i, k));
    }
  }
  return pairs;
}

/// Poses of all views that links connect to the largest group, along the links with most matches.
/// Marks the links that close loops.
Poses poses_along(const std::vector<PreparedView>& views, std::vector<ViewLink>& links) {
  std::stable_sort(links.begin(), links.end(), [](const ViewLink& a, const ViewLink& b) {
    return a.alignment.matches > b.alignment.matches;
  });

  Groups groups(views.size());
  for (ViewLink& link : links) link.closes_loop = !groups.connect(link.first, link.second);

  // The largest group, and of equal ones the first.
  std::vector<std::size_t> sizes(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) ++sizes[groups.root(i)];
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  Poses poses(views.size());
  poses[static_cast<std::size_t>(largest - sizes.begin())] = Eigen::Isometry3d::Identity();

  for (bool grows = true; grows;) {
    grows = false;
    for (const ViewLink& link : links) {
      std::optional<Eigen::Isometry3d>&first = poses[link.first], &second = poses[link.second];
      if (link.closes_loop || first.has_value() == second.has_value()) continue;
      if (first) {
        second = *first * link.alignment.pose;
      } else {
        first = *second * link.alignment.pose.inverse();
      }
      grows = true;
    }
  }
  return poses;
}

void add_pair(std::size_t first, std::size_t second, PairAlignment alignment,
              JointAlignment& joint) {
  auto& list = alignment.joined() ? joint.links : joint.refused;
  list.push_back({.first = first, .second = second, .alignment = std::move(alignment)});
}

/// Whether a pair is one of the links.
bool has_pair(const std::vector<ViewLink>& links, std::size_t first, std::size_t second) {
  return std::any_of(links.begin(), links.end(), [&](const ViewLink& link) {
    return link.first == first && link.second == second;
  });
}

/// Adds a pair that was compared at the poses of both views. A pair that joins leaves the refused
/// ones; a pair that is refused again keeps its first reason.
void add_compared(std::size_t first, std::size_t second, PairAlignment alignment,
                  JointAlignment& joint) {
  if (alignment.joined()) {
    std::erase_if(joint.refused, [&](const ViewLink& link) {
      return link.first == first && link.second == second;
    });
  } else if (has_pair(joint.refused, first, second)) {
    return;
  }
  add_pair(first, second, std::move(alignment), joint);
}

/// Aligns pairs without a start until all views are connected.
void link_without_start(const std::vector<PreparedView>& views, const JointSettings& settings,
                        JointAlignment& joint) {
  const auto pairs = pairs_in_order(views.size());
  Groups groups(views.size());

  for (std::size_t tried = 0; tried < pairs.size(); ++tried) {
    // Neighbours are all tried, so that a turn around the object closes.
    const auto [first, second] = pairs[tried];
    const bool neighbours = second - first == 1 || second - first == views.size() - 1;
    if (!neighbours && groups.all_connected()) break;
    if (!neighbours && groups.root(first) == groups.root(second)) continue;

    PairAlignment found = align_views(views[first], views[second], settings.pairs);
    if (found.joined()) groups.connect(first, second);
    add_pair(first, second, std::move(found), joint);
    if (settings.progress) {
      settings.progress(0.6 * static_cast<double>(tried + 1) / static_cast<double>(pairs.size()));
    }
  }
}

/// Whether spheres around both views, at their poses, come near each other.
bool may_overlap(const PreparedView& first, const PreparedView& second,
                 const Eigen::Isometry3d& pose) {
  return (pose * second.middle() - first.middle()).norm() < 2 * (first.reach() + second.reach());
}

/// All pairs that overlap at the poses so far and are not linked. A start may be rough.
std::vector<Overlap> overlaps_at(const std::vector<PreparedView>& views, const Poses& poses,
                                 const JointSettings& settings, const JointAlignment& joint) {
  const auto share = settings.starts.empty() ? overlap_at : rough_overlap_at;

  std::vector<Overlap> overlaps;
  for (std::size_t first = 0; first < views.size(); ++first) {
    for (std::size_t second = first + 1; second < views.size(); ++second) {
      if (!poses[first] || !poses[second] || has_pair(joint.links, first, second)) continue;

      const Eigen::Isometry3d start = poses[first]->inverse() * *poses[second];
      if (!may_overlap(views[first], views[second], start)) continue;
      const double found = share(views[first], views[second], start);
      if (found >= settings.pairs.least_overlap) overlaps.push_back({first, second, found});
    }
  }

  return overlaps;
}

/// Links pairs that overlap at the poses so far and are not linked.
void link_overlapping(const std::vector<PreparedView>& views, const Poses& poses,
                      const JointSettings& settings, JointAlignment& joint) {
  const std::vector<Overlap> pairs =
      spread_overlaps(overlaps_at(views, poses, settings, joint), views.size());

  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [first, second, share] = pairs[i];
    const Eigen::Isometry3d start = poses[first]->inverse() * *poses[second];
    PairAlignment found = refine_alignment(views[first], views[second], start, settings.pairs);

    // Two views of a plane part tell nothing alone, and contradict nothing.
    const bool weak = found.refusal == Refusal::slides || found.refusal == Refusal::no_overlap;
    if (!weak || !settings.starts.empty()) add_compared(first, second, std::move(found), joint);

    if (settings.progress) {
      settings.progress(0.6 + 0.3 * static_cast<double>(i + 1) / static_cast<double>(pairs.size()));
    }
  }
}

/// Drops the link that contradicts the poses most, if it does by more than a keypoint's cell.
/// Returns whether one was dropped.
bool drop_worst(const std::vector<PreparedView>& views, const Poses& poses, JointAlignment& joint) {
  double worst = 0;
  std::size_t which = 0;
  for (std::size_t i = 0; i < joint.links.size(); ++i) {
    ViewLink& link = joint.links[i];
    if (!poses[link.first] || !poses[link.second]) continue;
    const Eigen::Isometry3d by_others = poses[link.first]->inverse() * *poses[link.second];
    link.loop_error = contradiction(views[link.second], link.alignment.pose, by_others);
    if (link.loop_error > worst) {
      worst = link.loop_error;
      which = i;
    }
  }
  if (joint.links.empty() || worst < views.front().keypoints().cell) return false;

  ViewLink dropped = joint.links[which];
  dropped.alignment.refusal = Refusal::misfit;
  dropped.alignment.reason =
      fmt::format("the other pairs contradict it by {:.3g} mm", dropped.loop_error);
  joint.refused.push_back(std::move(dropped));
  joint.links.erase(joint.links.begin() + static_cast<std::ptrdiff_t>(which));
  return true;
}

/// How far the poses along the tree of links are off where further links close loops.
void measure_loops(const std::vector<PreparedView>& views, const Poses& poses,
                   JointAlignment& joint) {
  Squares errors, turns;
  for (const ViewLink& link : joint.links) {
    if (!link.closes_loop || !poses[link.first]) continue;
    const Eigen::Isometry3d by_tree = poses[link.first]->inverse() * *poses[link.second];
    const Eigen::Isometry3d difference = by_tree.inverse() * link.alignment.pose;
    errors.add(std::pow(contradiction(views[link.second], link.alignment.pose, by_tree), 2));
    turns.add(std::pow(Eigen::AngleAxisd(difference.linear()).angle() * 180 / std::numbers::pi, 2));
  }
  if (errors.count == 0) return;
  joint.loop_error = errors.rms();
  joint.loop_turn = turns.rms();
}

/// Compares each linked pair at the joint poses, in the order of the views.
void describe_links(const std::vector<PreparedView>& views, const JointSettings& settings,
                    JointAlignment& joint) {
  for (ViewLink& link : joint.links) {
    if (!joint.poses[link.first] || !joint.poses[link.second]) continue;
    const Eigen::Isometry3d pose = joint.poses[link.first]->inverse() * *joint.poses[link.second];
    link.loop_error = contradiction(views[link.second], link.alignment.pose, pose);
    link.alignment = alignment_at(views[link.first], views[link.second], pose, settings.pairs);
  }

  std::sort(joint.links.begin(), joint.links.end(), [](const ViewLink& a, const ViewLink& b) {
    return std::pair(a.first, a.second) < std::pair(b.first, b.second);
  });
}

/// Lists the pairs that do not fit at the joint poses: links, and pairs that were refused,
/// which may have been for other poses.
void find_misfits(const std::vector<PreparedView>& views, const JointSettings& settings,
                  JointAlignment& joint) {
  const auto is_misfit = [](const ViewLink& link) {
    return link.alignment.refusal == Refusal::misfit ||
           link.alignment.refusal == Refusal::sees_through;
  };

  for (const ViewLink& link : joint.links) {
    if (is_misfit(link)) joint.misfits.push_back(link);
  }

  for (const ViewLink& refused : joint.refused) {
    const auto &first = joint.poses[refused.first], &second = joint.poses[refused.second];
    if (!first || !second) continue;

    ViewLink link = refused;
    link.alignment = alignment_at(views[link.first], views[link.second], first->inverse() * *second,
                                  settings.pairs);
    if (is_misfit(link)) joint.misfits.push_back(std::move(link));
  }
}

/// Why a view stays alone: the reason of its pair with the most matches.
std::string reason_of(std::size_t view, const std::vector<PreparedView>& views,
                      const JointSettings& settings, const JointAlignment& joint) {
  if (!settings.starts.empty() && !settings.starts[view]) return "no start pose is given for it";

  const ViewLink* nearest = nullptr;
  for (const ViewLink& link : joint.refused) {
    if (link.first != view && link.second != view) continue;
    if (nearest == nullptr || link.alignment.matches > nearest->alignment.matches) nearest = &link;
  }
  if (nearest == nullptr) return "it shares no surface with the joined views";

  const std::size_t other = nearest->first == view ? nearest->second : nearest->first;
  return fmt::format("with {}: {}", views[other].view().name, nearest->alignment.reason);
}

}  // namespace

std::size_t JointAlignment::joined() const {
  return static_cast<std::size_t>(
      std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); }));
}

JointAlignment join_views(const std::vector<PreparedView>& views, const JointSettings& settings) {
  JointAlignment joint;
  joint.reasons.resize(views.size());

  // 1. Pairs: from the starts, or without one; then all others that overlap.
  const bool started = !settings.starts.empty();
  if (started) {
    joint.poses = settings.starts;
    link_overlapping(views, joint.poses, settings, joint);
    if (views.size() > 1 && joint.links.empty()) joint.poses.assign(views.size(), std::nullopt);
  } else {
    link_without_start(views, settings, joint);
  }
  joint.poses = poses_along(views, joint.links);
  if (!started) link_overlapping(views, joint.poses, settings, joint);

  // 2. The poses that fit all pairs together; pairs that contradict the rest are dropped.
  do {
    joint.poses = poses_along(views, joint.links);
    balance_links(views, joint.links, joint.poses);
  } while (drop_worst(views, joint.poses, joint));
  measure_loops(views, poses_along(views, joint.links), joint);
  refine_jointly(views, joint.links, settings.rounds, joint.poses);

  // 3. In the frame of the first view that is joined.
  const auto first = std::find_if(joint.poses.begin(), joint.poses.end(),
                                  [](const auto& pose) { return pose.has_value(); });
  const Eigen::Isometry3d home =
      first == joint.poses.end() ? Eigen::Isometry3d::Identity() : (*first)->inverse();
  for (auto& pose : joint.poses) {
    if (pose) pose = home * *pose;
  }

  // 4. How well each pair fits at the joint poses, and why views are left out.
  describe_links(views, settings, joint);
  find_misfits(views, settings, joint);
  if (joint.joined() < 2) joint.poses.assign(views.size(), std::nullopt);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!joint.poses[i]) joint.reasons[i] = reason_of(i, views, settings, joint);
  }
  if (settings.progress) settings.progress(1);
  return joint;
}

}  // namespace slipstream
