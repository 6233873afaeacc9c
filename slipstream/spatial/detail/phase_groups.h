#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "slipstream/spatial/detail/methods.h"

namespace slipstream {

/// Groups of pixels that know the orders of each other, each at first alone: a union-find whose
/// members remember by how many periods they lie above the one before.
class PhaseGroups {
 public:
  explicit PhaseGroups(std::size_t pixels) : members_(pixels) {}

  struct Place {
    int group = 0;
    int order = 0;  ///< above the group's
  };
  Place find(int pixel) {
    int order = 0;
    while (true) {
      Member& member = at(pixel);
      if (member.before < 0) return {pixel, order};
      const Member before = at(member.before);
      if (before.before < 0) return {member.before, order + member.order};
      member = {before.before, member.order + before.order};  // half of the way, the next time
      order += member.order;
      pixel = member.before;
    }
  }

  /// Makes one of both groups, with `step` periods from one pixel to the other; not where they are
  /// one.
  void join(int from, int to, int step) {
    Place first = find(from), second = find(to);
    if (first.group == second.group) return;
    step += first.order - second.order;
    if (at(first.group).before > at(second.group).before) {
      std::swap(first, second);
      step = -step;
    }
    at(first.group).before += at(second.group).before;
    at(second.group) = {first.group, step};
  }

  /// The number of the group of each pixel, from 0 to count() - 1.
  std::vector<int> numbered() {
    std::vector<int> numbers(members_.size(), -1);
    int next = 0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (members_[i].before < 0) numbers[i] = next++;
    }
    for (std::size_t i = 0; i < members_.size(); ++i) {
      numbers[i] = numbers[static_cast<std::size_t>(find(static_cast<int>(i)).group)];
    }
    return numbers;
  }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(std::count_if(
        members_.begin(), members_.end(), [](const Member& member) { return member.before < 0; }));
  }

  Orders orders(const WrappedCycles& wrapped) {
    Orders orders{Image<int>(wrapped.cycles.size()), Image<int>(wrapped.cycles.size(), -1)};
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (!wrapped.has(i)) continue;
      const Place place = find(static_cast<int>(i));
      orders.region.begin()[i] = place.group;
      orders.order.begin()[i] = place.order;
    }
    return orders;
  }

 private:
  struct Member {
    int before = -1;  ///< of a group's first: how many there are, negative
    int order = 0;    ///< above that before
  };
  Member& at(int pixel) { return members_[static_cast<std::size_t>(pixel)]; }

  std::vector<Member> members_;
};

}  // namespace slipstream
