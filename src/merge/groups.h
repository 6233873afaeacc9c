#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace slipstream {

/// Groups of things that are connected, such as views by links or vertices by triangles. Each is
/// alone at first.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  /// The least of its group.
  std::size_t root(std::size_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }

  /// False if they were connected already.
  bool connect(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

  bool all_connected() {
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      if (root(i) != 0) return false;
    }
    return true;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace slipstream
