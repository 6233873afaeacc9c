#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// A number for each cell of a grid, up to a million cells from its origin.
std::uint64_t cell_key(const Eigen::Vector3i& cell);

/// Points sorted into cubic cells, to find those near a place. Copies the points.
class PointGrid {
 public:
  PointGrid() = default;

  /// `cell`: edge of a cell, above 0; searches of about that radius are fastest.
  PointGrid(std::span<const Eigen::Vector3f> points, float cell);

  /// Calls `visit(index, squared_distance)` for each point at most `radius` from a place.
  template <class Visit>
  void for_each_near(const Eigen::Vector3f& place, float radius, const Visit& visit) const {
    const Eigen::Vector3i low = cell_of(place.array() - radius);
    const Eigen::Vector3i high = cell_of(place.array() + radius);

    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int z = low.z(); z <= high.z(); ++z) {
          const auto [first, end] = range_of(cell_key({x, y, z}));
          for (std::uint32_t i = first; i < end; ++i) {
            const float squared = (points_[i] - place).squaredNorm();
            if (squared <= radius * radius) visit(indices_[i], squared);
          }
        }
      }
    }
  }

  /// Index of the nearest point at most `radius` away; nullopt without any.
  [[nodiscard]] std::optional<std::uint32_t> nearest(const Eigen::Vector3f& place,
                                                     float radius) const;

 private:
  struct Range {
    std::uint32_t first = 0, end = 0;
  };

  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& place) const {
    return ((place - origin_) / cell_).array().floor().cast<int>();
  }
  [[nodiscard]] Range range_of(std::uint64_t key) const;

  struct Slot {
    std::uint64_t key = 0;
    Range range{};
  };

  float cell_ = 1;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  std::vector<Eigen::Vector3f> points_{};  ///< sorted by cell
  std::vector<std::uint32_t> indices_{};   ///< of the sorted points, as given
  std::vector<Slot> slots_{};              ///< hash table of the cells; its size is a power of 2
};

/// One point for each cubic cell of that edge: the index of the point nearest to the mean of the
/// cell's points, in a fixed order.
std::vector<std::uint32_t> thinned_to_cells(std::span<const Eigen::Vector3f> points, float cell);

}  // namespace slipstream
