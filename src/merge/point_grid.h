#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// A number for each cell of a grid, up to a million cells from its origin.
std::uint64_t cell_key(const Eigen::Vector3i& cell);

/// Points in and around a cell of a grid.
struct NearPoints {
  std::vector<std::uint32_t> indices{};  ///< as given to the grid
  std::vector<float> x{}, y{}, z{};

  /// Calls `visit(i, offset)` for each point i of these lists at most `radius` from a place.
  template <class Visit>
  void for_each_near(const Eigen::Vector3f& place, float radius, const Visit& visit) const {
    // 1. Several distances at a time, as the compiler makes vectors of this loop.
    thread_local std::vector<float> squares;
    squares.resize(indices.size());
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const float right = x[i] - place.x(), down = y[i] - place.y(), far = z[i] - place.z();
      squares[i] = right * right + down * down + far * far;
    }

    // 2. The near ones, without a branch that the processor would guess wrong for every third.
    thread_local std::vector<std::size_t> found;
    found.resize(squares.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < squares.size(); ++i) {
      found[count] = i;
      count += squares[i] <= radius * radius ? 1 : 0;
    }

    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = found[k];
      visit(i, Eigen::Vector3f(x[i], y[i], z[i]) - place);
    }
  }
};

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

  /// Calls `visit(inside, near)` for each cell with points, on several threads. `inside`: the
  /// indices of its points. `near`: the points in the cell and in those beside it, among them
  /// every point within the edge of a cell from a point inside. Faster than a search for each
  /// point, if all points are visited.
  using VisitCell = std::function<void(std::span<const std::uint32_t>, const NearPoints&)>;
  void for_each_cell(const VisitCell& visit) const;

  /// Index of the nearest point at most `radius` away; nullopt without any.
  [[nodiscard]] std::optional<std::uint32_t> nearest(const Eigen::Vector3f& place,
                                                     float radius) const;

 private:
  struct Range {
    std::uint32_t first = 0, end = 0;
  };

  /// Column, row and layer of a place's block, possibly outside all of them.
  [[nodiscard]] Eigen::Array3f block_of(const Eigen::Vector3f& place) const {
    return ((place - origin_).array() / block_).floor() + 1;
  }
  [[nodiscard]] std::size_t number_of(const Eigen::Array3i& block) const {
    return static_cast<std::size_t>((block.x() * blocks_.y() + block.y()) * blocks_.z() +
                                    block.z());
  }
  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3f& place) const {
    return ((place - origin_) / cell_).array().floor().cast<int>();
  }
  [[nodiscard]] Range range_of(std::uint64_t key) const;

  void mark_blocks();
  /// False only if no point is as near to a place as a block's edge is long.
  [[nodiscard]] bool is_near_points(const Eigen::Vector3f& place) const;

  struct Slot {
    std::uint64_t key = 0;
    Range range{};
  };

  float cell_ = 1;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  std::vector<Eigen::Vector3f> points_{};  ///< sorted by cell
  std::vector<std::uint32_t> indices_{};   ///< of the sorted points, as given
  std::vector<std::uint32_t> firsts_{};    ///< of each cell's points, and the end of the last
  std::vector<Slot> slots_{};              ///< hash table of the cells; its size is a power of 2

  // Coarse blocks around all points, one more on each side.
  float block_ = 1;                                 ///< edge, mm
  Eigen::Array3i blocks_ = Eigen::Array3i::Zero();  ///< number along each axis
  std::vector<bool> near_points_{};                 ///< whether it or one beside it has points
};

/// One point for each cubic cell of that edge: the index of the point nearest to the mean of the
/// cell's points, in a fixed order.
std::vector<std::uint32_t> thinned_to_cells(std::span<const Eigen::Vector3f> points, float cell);

}  // namespace slipstream
