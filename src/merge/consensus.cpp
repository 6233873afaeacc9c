#include "merge/consensus.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include <Eigen/Geometry>

#include "base/parallel_rows.h"
#include "geometry/point_fit.h"

namespace slipstream {
namespace {

/// A correspondence by its points and normals.
struct Pairing {
  Eigen::Vector3f first, first_normal, second, second_normal;
};

/// Whether both lie on one rigid body: equal distance, and equal angles of the normals.
bool are_compatible(const Pairing& a, const Pairing& b, float cell) {
  constexpr float nearest = 3, most_apart = 1.2F;  // cells
  constexpr float most_turned = 0.25F;             // cosines

  const Eigen::Vector3f first = b.first - a.first, second = b.second - a.second;
  const float first_length = first.norm(), second_length = second.norm();
  if (first_length < nearest * cell || second_length < nearest * cell) return false;
  if (std::abs(first_length - second_length) > most_apart * cell) return false;

  const auto differ = [](float x, float y) { return std::abs(x - y) > most_turned; };
  return !differ(a.first_normal.dot(b.first_normal), a.second_normal.dot(b.second_normal)) &&
         !differ(a.first_normal.dot(first) / first_length,
                 a.second_normal.dot(second) / second_length) &&
         !differ(b.first_normal.dot(first) / first_length,
                 b.second_normal.dot(second) / second_length);
}

/// As std::popcount, which is a function call in programs for all x86 processors.
int bits_in(std::uint64_t word) {
  word -= word >> 1 & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + (word >> 2 & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>(word * 0x0101010101010101U >> 56);
}

/// A bit for each pair of correspondences.
class CompatibilityTable {
 public:
  CompatibilityTable(std::span<const Pairing> pairings, float cell)
      : count_(pairings.size()), words_((count_ + 63) / 64), bits_(count_ * words_) {
    for_each_row(static_cast<int>(count_), [&](int row) {
      const auto i = static_cast<std::size_t>(row);
      for (std::size_t k = 0; k < count_; ++k) {
        if (k != i && are_compatible(pairings[i], pairings[k], cell)) {
          bits_[i * words_ + k / 64] |= std::uint64_t{1} << (k % 64);
        }
      }
    });
  }

  [[nodiscard]] bool compatible(std::size_t i, std::size_t k) const {
    return (bits_[i * words_ + k / 64] >> (k % 64) & 1U) != 0;
  }
  /// Number of correspondences compatible with both.
  [[nodiscard]] int common(std::size_t i, std::size_t k) const {
    int sum = 0;
    for (std::size_t word = 0; word < words_; ++word) {
      sum += bits_in(bits_[i * words_ + word] & bits_[k * words_ + word]);
    }
    return sum;
  }

 private:
  std::size_t count_, words_;
  std::vector<std::uint64_t> bits_;
};

/// The compatible correspondences with the most common ones, besides the seed itself.
std::vector<std::size_t> companions(const CompatibilityTable& table, std::size_t seed,
                                    std::size_t count) {
  constexpr std::size_t most = 30;

  std::vector<std::pair<int, std::size_t>> rated;
  for (std::size_t k = 0; k < count; ++k) {
    if (table.compatible(seed, k)) rated.emplace_back(-table.common(seed, k), k);
  }
  std::sort(rated.begin(), rated.end());
  if (rated.size() > most) rated.resize(most);

  std::vector<std::size_t> members{seed};
  for (const auto& [common, k] : rated) members.push_back(k);
  return members;
}

/// The motion of the second view that brings these correspondences together by least squares.
Eigen::Isometry3d motion_of(std::span<const Pairing> pairings,
                            const std::vector<std::size_t>& members) {
  const auto count = static_cast<Eigen::Index>(members.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Pairing& pairing = pairings[members[static_cast<std::size_t>(i)]];
    from.col(i) = pairing.second.cast<double>();
    to.col(i) = pairing.first.cast<double>();
  }
  return motion_between_points(from, to);
}

/// The correspondences that fit a pose.
std::vector<std::size_t> supporters(std::span<const Pairing> pairings,
                                    const Eigen::Isometry3d& pose, float farthest) {
  constexpr float least_alike = 0.7F;

  std::vector<std::size_t> members;
  const Eigen::Isometry3f motion = pose.cast<float>();
  for (std::size_t k = 0; k < pairings.size(); ++k) {
    const Pairing& p = pairings[k];
    const bool near = (motion * p.second - p.first).squaredNorm() < farthest * farthest;
    if (near && (motion.linear() * p.second_normal).dot(p.first_normal) > least_alike) {
      members.push_back(k);
    }
  }
  return members;
}

/// Correspondences with companions, those with the most common ones first.
std::vector<std::size_t> seeds_in_order(const CompatibilityTable& table, std::size_t count) {
  std::vector<std::int64_t> weight(count);
  for_each_row(static_cast<int>(count), [&](int row) {
    const auto i = static_cast<std::size_t>(row);
    for (std::size_t k = 0; k < count; ++k) {
      if (table.compatible(i, k)) weight[i] += table.common(i, k);
    }
  });

  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return weight[i] == 0; });
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weight[a] > weight[b]; });
  return order;
}

}  // namespace

double largest_displacement(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                            const Eigen::Vector3d& middle, double reach) {
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign(corner % 2 * 2 - 1, corner / 2 % 2 * 2 - 1, corner / 4 * 2 - 1);
    const Eigen::Vector3d place = middle + reach * sign / std::sqrt(3.0);
    most = std::max(most, (a * place - b * place).norm());
  }
  return most;
}

std::vector<ConsensusPose> consensus_poses(const Keypoints& first, const Keypoints& second,
                                           std::span<const Correspondence> correspondences,
                                           std::size_t most) {
  constexpr int seeds = 200;
  constexpr float near_cells = 1.5F, distinct_cells = 4;
  constexpr int least_support = 5;

  // 1. Which correspondences agree in pairs.
  std::vector<Pairing> pairings;
  for (const auto& [from, to] : correspondences) {
    const auto i = static_cast<std::size_t>(from), k = static_cast<std::size_t>(to);
    pairings.push_back({first.points[i], first.normals[i], second.points[k], second.normals[k]});
  }
  const float cell = std::max(first.cell, second.cell);
  const CompatibilityTable table(pairings, cell);

  // 2. Seeds: those with the most common companions.
  const std::vector<std::size_t> order = seeds_in_order(table, pairings.size());

  // 3. A pose from each seed that no earlier pose explains.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : second.points) {
    middle += point.cast<double>() / static_cast<double>(second.points.size());
  }
  double half = 0;
  for (const Eigen::Vector3f& point : second.points) {
    half = std::max(half, (point.cast<double>() - middle).norm());
  }

  std::vector<ConsensusPose> poses;
  std::vector<bool> explained(pairings.size());
  int tried = 0;
  for (const std::size_t seed : order) {
    if (tried == seeds) break;
    if (explained[seed]) continue;
    ++tried;

    std::vector<std::size_t> members = companions(table, seed, pairings.size());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int round = 0; round < 4 && members.size() >= 3; ++round) {
      pose = motion_of(pairings, members);
      members = supporters(pairings, pose, near_cells * cell);
    }
    if (static_cast<int>(members.size()) < least_support) continue;
    for (const std::size_t k : members) explained[k] = true;

    const bool known = std::any_of(poses.begin(), poses.end(), [&](const ConsensusPose& other) {
      return largest_displacement(pose, other.pose, middle, half) < distinct_cells * cell;
    });
    if (!known) poses.push_back({pose, static_cast<int>(members.size())});
  }

  std::stable_sort(poses.begin(), poses.end(), [](const ConsensusPose& a, const ConsensusPose& b) {
    return a.support > b.support;
  });
  if (poses.size() > most) poses.resize(most);
  return poses;
}

}  // namespace slipstream
