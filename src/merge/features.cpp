#include "merge/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "base/parallel_rows.h"
#include "merge/point_grid.h"

namespace slipstream {
namespace {

constexpr int angle_bins = feature_bins / 3;

/// Place of a value from `low` to `high` in a histogram of angle_bins.
int bin_of(float value, float low, float high) {
  const float share = (value - low) / (high - low);
  return std::clamp(static_cast<int>(share * angle_bins), 0, angle_bins - 1);
}

/// Adds the three angles of a pair of points with normals (equation 1 of the paper).
void add_angles(Eigen::Ref<Eigen::VectorXf> histogram, const Eigen::Vector3f& from,
                const Eigen::Vector3f& from_normal, const Eigen::Vector3f& to,
                const Eigen::Vector3f& to_normal) {
  Eigen::Vector3f line = (to - from).normalized();
  Eigen::Vector3f u = from_normal, other = to_normal;

  // The frame stands on the point whose normal is nearer to the line.
  if (std::abs(u.dot(line)) < std::abs(other.dot(line))) {
    std::swap(u, other);
    line = -line;
  }

  Eigen::Vector3f v = u.cross(line);
  if (!(v.squaredNorm() > 1e-12F)) return;
  v.normalize();
  const Eigen::Vector3f w = u.cross(v);

  constexpr auto pi = std::numbers::pi_v<float>;
  histogram(bin_of(v.dot(other), -1, 1)) += 1;
  histogram(angle_bins + bin_of(u.dot(line), -1, 1)) += 1;
  histogram(2 * angle_bins + bin_of(std::atan2(w.dot(other), u.dot(other)), -pi, pi)) += 1;
}

/// Scales each of the three histograms of every point to the sum 100.
void normalise(Features& features) {
  for (Eigen::Index i = 0; i < features.cols(); ++i) {
    for (int part = 0; part < 3; ++part) {
      auto bins = features.col(i).segment<angle_bins>(part * angle_bins);
      const float sum = bins.sum();
      if (sum > 0) bins *= 100 / sum;
    }
  }
}

Features features_of(const Keypoints& keypoints) {
  constexpr float reach = 5;  // cells

  const float radius = reach * keypoints.cell;
  const PointGrid grid(keypoints.points, radius / 2);
  const auto count = static_cast<int>(keypoints.points.size());

  // 1. Each point's own angles to its neighbours.
  Features own = Features::Zero(feature_bins, count);
  std::vector<std::vector<std::pair<int, float>>> neighbours(keypoints.points.size());
  for_each_row(count, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    grid.for_each_near(keypoints.points[at], radius, [&](std::uint32_t k, float squared) {
      if (k == at || !(squared > 0)) return;
      neighbours[at].emplace_back(static_cast<int>(k), squared);
      add_angles(own.col(i), keypoints.points[at], keypoints.normals[at], keypoints.points[k],
                 keypoints.normals[k]);
    });
  });
  normalise(own);

  // 2. And those of the neighbours, the near ones more.
  Features all = own;
  for_each_row(count, [&](int i) {
    const auto& near = neighbours[static_cast<std::size_t>(i)];
    for (const auto& [k, squared] : near) {
      all.col(i) += own.col(k) * (keypoints.cell * keypoints.cell / squared) /
                    static_cast<float>(near.size());
    }
  });
  normalise(all);

  return all;
}

/// The most similar keypoint of `to` for one of `from`, and the most similar elsewhere on the
/// surface, with the distances of their features.
struct SimilarPair {
  std::array<int, 2> to{-1, -1};
  std::array<float, 2> distance{};
};

/// `elsewhere`: the least distance of the two from each other, or with `itself` of both from the
/// keypoint, which then is of the same view, cells.
std::vector<SimilarPair> most_similar(const Keypoints& from, const Keypoints& to, bool itself) {
  constexpr int block = 64;
  constexpr float elsewhere = 3, other_place = 6;  // cells

  const auto count = static_cast<int>(from.points.size());
  std::vector<SimilarPair> similar(from.points.size());
  const Eigen::VectorXf squares = to.features.colwise().squaredNorm();

  // Blocks of points at once, as a product of matrices.
  for_each_row((count + block - 1) / block, [&](int part) {
    const int first = part * block, size = std::min(block, count - first);
    Eigen::MatrixXf distances =
        -2 * to.features.transpose() * from.features.middleCols(first, size);
    distances.colwise() += squares;

    for (int i = 0; i < size; ++i) {
      const auto place = static_cast<std::size_t>(first + i);
      const float own = from.features.col(first + i).squaredNorm();
      SimilarPair& pair = similar[place];

      for (std::size_t rank = 0; rank < 2; ++rank) {
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t k = 0; k < to.points.size(); ++k) {
          const float other = distances(static_cast<Eigen::Index>(k), i);
          if (other >= least) continue;

          const auto apart = [&](const Eigen::Vector3f& point) {
            return (to.points[k] - point).norm() / to.cell;
          };
          if (itself && apart(from.points[place]) < other_place) continue;
          if (rank == 1 && apart(to.points[static_cast<std::size_t>(pair.to[0])]) < elsewhere) {
            continue;
          }
          least = other;
          pair.to[rank] = static_cast<int>(k);
        }
        pair.distance[rank] = std::sqrt(std::max(least + own, 0.0F));
        if (pair.to[rank] < 0) break;
      }
    }
  });

  return similar;
}

/// How far each feature is from the mean of all.
std::vector<float> distinctness(const Keypoints& keypoints) {
  const Eigen::VectorXf mean = keypoints.features.rowwise().mean();
  std::vector<float> distances;
  for (Eigen::Index i = 0; i < keypoints.features.cols(); ++i) {
    distances.push_back((keypoints.features.col(i) - mean).norm());
  }
  return distances;
}

}  // namespace

Keypoints keypoints_of(const View& view, float cell) {
  Keypoints keypoints{.cell = cell};
  const std::vector<std::uint32_t> kept = thinned_to_cells(view.points, cell);

  const PointGrid grid(view.points, cell);
  keypoints.points.resize(kept.size());
  keypoints.normals.resize(kept.size());
  for_each_row(static_cast<int>(kept.size()), [&](int row) {
    const auto i = static_cast<std::size_t>(row);
    Eigen::Vector3f point = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    float count = 0;
    grid.for_each_near(view.points[kept[i]], 0.7F * cell, [&](std::uint32_t k, float) {
      point += view.points[k];
      normal += view.normals[k];
      ++count;
    });
    keypoints.points[i] = point / count;
    keypoints.normals[i] = normal.squaredNorm() > 0 ? normal.normalized() : view.normals[kept[i]];
  });

  keypoints.features = features_of(keypoints);
  return keypoints;
}

std::vector<Correspondence> similar_keypoints(const Keypoints& first, const Keypoints& second,
                                              std::size_t most) {
  struct Rated {
    float rating;
    int first, second;
  };
  std::vector<Rated> rated;
  std::set<std::pair<int, int>> taken;

  // The distance of two features counts relative to how much they stand out.
  const bool itself = &first == &second;
  const auto rate = [&](const Keypoints& from, const Keypoints& to, bool back) {
    const std::vector<SimilarPair> similar = most_similar(from, to, itself);
    const std::vector<float> distinct = distinctness(from);
    for (std::size_t i = 0; i < similar.size(); ++i) {
      for (std::size_t rank = 0; rank < 2; ++rank) {
        const int here = static_cast<int>(i), there = similar[i].to[rank];
        if (there < 0) break;
        const std::pair pair = back ? std::pair(there, here) : std::pair(here, there);
        if (!taken.insert(pair).second) continue;
        rated.push_back(
            {similar[i].distance[rank] / std::max(distinct[i], 1e-3F), pair.first, pair.second});
      }
    }
  };
  rate(first, second, false);
  if (!itself) rate(second, first, true);

  std::sort(rated.begin(), rated.end(), [](const Rated& a, const Rated& b) {
    return std::tie(a.rating, a.first, a.second) < std::tie(b.rating, b.first, b.second);
  });
  std::vector<Correspondence> similar;
  for (const Rated& pair : rated) {
    if (similar.size() == most) break;
    similar.push_back({pair.first, pair.second});
  }
  return similar;
}

}  // namespace slipstream
