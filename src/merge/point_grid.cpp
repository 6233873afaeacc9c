#include "merge/point_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "base/parallel_rows.h"

namespace slipstream {
namespace {

/// Spreads keys of neighbouring cells over a table of that size, a power of 2 above 1. Only the
/// highest bits of the product depend on all parts of a key.
std::size_t slot_of(std::uint64_t key, std::size_t size) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> (64 - std::countr_zero(size)));
}

struct CellPoint {
  std::uint64_t cell = 0;
  std::uint32_t point = 0;
};

/// Sorts points, whose numbers ascend, by their cell: digit after digit of the keys, from the low
/// to the high ones.
std::vector<CellPoint> sorted_by_cell(std::vector<CellPoint> all) {
  constexpr std::uint64_t digit_mask = 2047;
  std::vector<CellPoint> sorted(all.size());

  // Two digits for each axis; few grids have more than one of them.
  for (const int shift : {0, 11, 21, 32, 42, 53}) {
    const auto digit = [&](const CellPoint& point) { return point.cell >> shift & digit_mask; };
    std::array<std::size_t, digit_mask + 2> begin{};
    for (const CellPoint& point : all) ++begin[digit(point) + 1];
    if (std::ranges::find(begin, all.size()) != begin.end()) continue;

    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (const CellPoint& point : all) sorted[begin[digit(point)]++] = point;
    std::swap(all, sorted);
  }
  return all;
}

Eigen::Vector3f lowest_corner(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  if (!points.empty()) low = points[0];
  for (const Eigen::Vector3f& point : points) low = low.cwiseMin(point);
  return low;
}

}  // namespace

std::uint64_t cell_key(const Eigen::Vector3i& cell) {
  constexpr std::uint64_t mask = (1U << 21U) - 1;
  const auto part = [](int number) { return static_cast<std::uint64_t>(number) & mask; };
  return part(cell.x()) << 42U | part(cell.y()) << 21U | part(cell.z());
}

PointGrid::PointGrid(std::span<const Eigen::Vector3f> points, float cell)
    : cell_(cell), origin_(lowest_corner(points)) {
  // 1. Sort the points by their cell.
  std::vector<CellPoint> all(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    all[i] = {cell_key(cell_of(points[i])), static_cast<std::uint32_t>(i)};
  }
  all = sorted_by_cell(std::move(all));

  points_.reserve(points.size());
  indices_.reserve(points.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    points_.push_back(points[all[i].point]);
    indices_.push_back(all[i].point);
    if (i == 0 || all[i].cell != all[i - 1].cell) firsts_.push_back(static_cast<std::uint32_t>(i));
  }
  firsts_.push_back(static_cast<std::uint32_t>(all.size()));

  // 2. Put each cell's range into the hash table, at most half full, of two slots or more.
  slots_.resize(std::bit_ceil(2 * firsts_.size()));
  for (std::size_t i = 0; i + 1 < firsts_.size(); ++i) {
    const std::uint64_t key = all[firsts_[i]].cell;
    std::size_t slot = slot_of(key, slots_.size());
    while (slots_[slot].range.end != 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = {key, {firsts_[i], firsts_[i + 1]}};
  }

  mark_blocks();
}

void PointGrid::mark_blocks() {
  constexpr float cells = 4;          // along a block, at least
  constexpr float most_blocks = 100;  // along the longest axis

  Eigen::Array3f extent = Eigen::Array3f::Zero();
  for (const Eigen::Vector3f& point : points_) extent = extent.max((point - origin_).array());
  block_ = std::max(cells * cell_, extent.maxCoeff() / most_blocks);
  blocks_ = (extent / block_).floor().cast<int>() + 3;
  near_points_.assign(static_cast<std::size_t>(blocks_.prod()), false);

  Eigen::Array3i marked = Eigen::Array3i::Zero();
  for (const Eigen::Vector3f& point : points_) {
    const Eigen::Array3i block = block_of(point).cast<int>();
    if ((block == marked).all()) continue;  // as of most points before, which are sorted by cell
    marked = block;

    for (int k = 0; k < 27; ++k) {
      const Eigen::Array3i beside(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
      near_points_[number_of(block + beside)] = true;
    }
  }
}

bool PointGrid::is_near_points(const Eigen::Vector3f& place) const {
  const Eigen::Array3f block = block_of(place);
  if (!(block >= 0).all() || !(block < blocks_.cast<float>()).all()) return false;
  return near_points_[number_of(block.cast<int>())];
}

void PointGrid::for_each_cell(const VisitCell& visit) const {
  if (firsts_.empty()) return;
  for_each_row(static_cast<int>(firsts_.size()) - 1, [&](int cell) {
    thread_local NearPoints near;
    for (auto* const list : {&near.x, &near.y, &near.z}) list->clear();
    near.indices.clear();

    const auto first = firsts_[cell], end = firsts_[cell + 1];
    const Eigen::Vector3i middle = cell_of(points_[first]);
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i beside(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
      const Range range = range_of(cell_key(middle + beside));
      for (std::uint32_t i = range.first; i < range.end; ++i) {
        near.indices.push_back(indices_[i]);
        near.x.push_back(points_[i].x());
        near.y.push_back(points_[i].y());
        near.z.push_back(points_[i].z());
      }
    }
    visit(std::span(indices_).subspan(first, end - first), near);
  });
}

PointGrid::Range PointGrid::range_of(std::uint64_t key) const {
  if (slots_.empty()) return {};
  std::size_t slot = slot_of(key, slots_.size());
  while (slots_[slot].range.end != 0) {
    if (slots_[slot].key == key) return slots_[slot].range;
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return {};
}

std::optional<std::uint32_t> PointGrid::nearest(const Eigen::Vector3f& place, float radius) const {
  if (radius <= block_ && !is_near_points(place)) return std::nullopt;

  // Most have one very near, which takes few cells to find.
  const float first_radius = std::min(radius, cell_ / 4);
  for (const float reach : {first_radius, radius}) {
    float least = std::numeric_limits<float>::infinity();
    std::optional<std::uint32_t> found;
    for_each_near(place, reach, [&](std::uint32_t index, float squared) {
      if (squared < least) {
        least = squared;
        found = index;
      }
    });
    if (found || reach == radius) return found;
  }
  return std::nullopt;
}

std::vector<std::uint32_t> thinned_to_cells(std::span<const Eigen::Vector3f> points, float cell) {
  const Eigen::Vector3f origin = lowest_corner(points);
  std::vector<CellPoint> all(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3i place = ((points[i] - origin) / cell).array().floor().cast<int>();
    all[i] = {cell_key(place), static_cast<std::uint32_t>(i)};
  }
  all = sorted_by_cell(std::move(all));

  // Of each cell the point nearest to the mean: a mean itself would lie off a curved surface.
  std::vector<std::uint32_t> kept;
  for (std::size_t first = 0; first < all.size();) {
    std::size_t end = first;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (; end < all.size() && all[end].cell == all[first].cell; ++end) {
      sum += points[all[end].point];
    }

    const Eigen::Vector3f mean = sum / static_cast<float>(end - first);
    const auto nearer = [&](const CellPoint& a, const CellPoint& b) {
      return (points[a.point] - mean).squaredNorm() < (points[b.point] - mean).squaredNorm();
    };
    const auto begin = all.begin();
    kept.push_back(std::min_element(begin + static_cast<std::ptrdiff_t>(first),
                                    begin + static_cast<std::ptrdiff_t>(end), nearer)
                       ->point);
    first = end;
  }
  return kept;
}

}  // namespace slipstream
