#include "slipstream/simulate/moved_board.h"

#include <iterator>

#include "slipstream/base/error.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream {
namespace {

/// Share of the way from one pose to another.
Eigen::Isometry3d between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) {
  const Eigen::Quaterniond turn(from.linear()), end(to.linear());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate((1 - share) * from.translation() + share * to.translation());
  pose.rotate(turn.slerp(share, end));
  return pose;
}

/// Each pattern alone, in the order in which they are shown.
std::vector<PatternSet> cycle_of(const std::vector<PatternSet>& sets) {
  std::vector<PatternSet> cycle;
  for (const PatternSet& set : sets) {
    for (int n = 0; n < set.count; ++n) cycle.push_back(pattern_alone(set, n));
  }
  return cycle;
}

}  // namespace

Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered) {
  if (poses.empty() || sets.empty() || still_cycles < 1) {
    throw Error("a board that is moved needs a pose, a set of patterns and a cycle at least");
  }
  const std::vector<PatternSet> cycle = cycle_of(sets);
  Photometry photometry = world.photometry;
  photometry.rays = 1;  // what is printed on a sheet has soft edges of its own
  Reel reel;
  const auto expose = [&](const PatternSet& patterns) {
    std::vector<Frame> seen = virtual_frames(world.scanner, {sheet}, patterns, photometry, 1);
    photometry.seed += seen.size();
    reel.frames.insert(reel.frames.end(), std::make_move_iterator(seen.begin()),
                       std::make_move_iterator(seen.end()));
  };
  for (std::size_t p = 0; p < poses.size(); ++p) {
    const std::size_t first = reel.frames.size();
    reel.enough = reel.order.size() + cycle.size();  // who takes a pose sees a cycle of it
    sheet.pose = poses[p];
    for (const PatternSet& set : sets) expose(set);
    for (std::size_t k = 0; k < cycle.size() * static_cast<std::size_t>(still_cycles); ++k) {
      reel.order.push_back(first + k % cycle.size());
    }
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(cycle.size() + 1);
      sheet.pose = between(poses[p], poses[(p + 1) % poses.size()], share);
      reel.order.push_back(reel.frames.size());
      expose(cycle[k]);
    }
    rendered();
  }
  return reel;
}

}  // namespace slipstream
