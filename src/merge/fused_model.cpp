#include "merge/fused_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "merge/point_grid.h"

namespace slipstream {
namespace {

/// Points of all views in the model's frame.
struct AllPoints {
  std::vector<Eigen::Vector3f> points, normals;
  std::vector<float> sigma, intensity;
  std::vector<Colour> colours;
  std::vector<std::uint16_t> view;
};

AllPoints collected(const std::vector<const View*>& views,
                    const std::vector<std::optional<Eigen::Isometry3d>>& poses, bool coloured) {
  AllPoints all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!poses[i]) continue;
    const View& view = *views[i];
    const Eigen::Isometry3d& pose = *poses[i];
    for (std::size_t k = 0; k < view.size(); ++k) {
      all.points.push_back((pose * view.points[k].cast<double>()).cast<float>());
      all.normals.push_back((pose.linear() * view.normals[k].cast<double>()).cast<float>());
      all.sigma.push_back(view.sigma[k]);
      all.intensity.push_back(view.intensity[k]);
      if (coloured) all.colours.push_back(view.colours[k]);
      all.view.push_back(static_cast<std::uint16_t>(i));
    }
  }
  return all;
}

/// Weighted sums over the points of one view near a place.
struct ViewSums {
  std::uint16_t view = 0;
  double weight = 0, height = 0;
};

/// How far the views' means scatter, in standard deviations, if that is more than three; else 1.
double scatter_of(std::span<const ViewSums> views) {
  constexpr double most_of_noise = 3;
  if (views.size() < 2) return 1;

  double weight = 0, height = 0;
  for (const ViewSums& sums : views) {
    weight += sums.weight;
    height += sums.height;
  }

  double squares = 0;
  for (const ViewSums& sums : views) {
    squares += sums.weight * std::pow(sums.height / sums.weight - height / weight, 2);
  }
  const double scatter = std::sqrt(squares / static_cast<double>(views.size() - 1));
  return scatter > most_of_noise ? scatter : 1;
}

/// Averages the points around `seed` on its surface. Its neighbours are those in a disc across the
/// normal, so that noise does not decide which belong to it.
class PointAverage {
 public:
  PointAverage(const AllPoints& all, float spacing) : all_(all), spacing_(spacing) {}

  /// How far neighbours lie from a seed at most.
  static float reach(float spacing) { return 2 * spacing; }

  /// `points`: contain all within reach of the seed.
  [[nodiscard]] ModelPoint at(std::uint32_t seed, const NearPoints& points, bool coloured) const {
    thread_local std::vector<std::uint32_t> around;
    thread_local std::vector<std::pair<std::uint32_t, float>> near;
    thread_local std::vector<double> heights;
    around.clear();
    near.clear();
    heights.clear();

    const Eigen::Vector3f& origin = all_.points[seed];
    points.for_each_near(origin, reach(spacing_), [&](std::size_t i, const Eigen::Vector3f&) {
      around.push_back(points.indices[i]);
    });
    const Eigen::Vector3f normal = mean_normal(seed, around);

    // 1. The neighbours on the same side of the surface, and their heights over the seed.
    for (const std::uint32_t i : around) {
      if (!(all_.normals[i].dot(normal) > least_alike)) continue;
      const Eigen::Vector3f offset = all_.points[i] - origin;
      const float height = offset.dot(normal);
      if ((offset - height * normal).norm() > radius()) continue;
      near.emplace_back(i, height);
      heights.push_back(height);
    }

    // 2. Heights off the middle by more than their noise allows are outliers.
    const double middle = quantile(heights, 0.5);
    for (double& height : heights) height = std::abs(height - middle);
    const double spread = deviation_from_median(quantile(heights, 0.5));
    std::erase_if(near, [&](const auto& point) {
      const double limit = 4 * std::max<double>(spread, all_.sigma[point.first]);
      return std::abs(point.second - middle) > limit;
    });

    return averaged(near, normal, coloured);
  }

 private:
  static constexpr float least_alike = 0.5F;
  [[nodiscard]] float radius() const { return 0.75F * spacing_; }

  [[nodiscard]] Eigen::Vector3f mean_normal(std::uint32_t seed,
                                            const std::vector<std::uint32_t>& around) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const std::uint32_t i : around) {
      if (all_.normals[i].dot(all_.normals[seed]) > least_alike) sum += all_.normals[i];
    }
    return sum.normalized();
  }

  [[nodiscard]] ModelPoint averaged(const std::vector<std::pair<std::uint32_t, float>>& near,
                                    const Eigen::Vector3f& normal, bool coloured) const {
    ModelPoint point{.normal = normal};
    thread_local std::vector<ViewSums> views;
    views.clear();
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), colour = Eigen::Vector3d::Zero();
    double weights = 0, intensity = 0;

    for (const auto& [i, height] : near) {
      const double weight = 1 / (double{all_.sigma[i]} * all_.sigma[i]);
      weights += weight;
      position += weight * all_.points[i].cast<double>();
      intensity += weight * all_.intensity[i];
      if (coloured) {
        const auto [red, green, blue] = all_.colours[i];
        colour += weight * Eigen::Vector3d(red, green, blue);
      }

      auto of_view = std::find_if(views.begin(), views.end(), [&, index = i](const ViewSums& sums) {
        return sums.view == all_.view[index];
      });
      if (of_view == views.end()) {
        views.push_back({.view = all_.view[i]});
        of_view = std::prev(views.end());
      }
      of_view->weight += weight;
      of_view->height += weight * height;
    }
    if (near.empty()) return point;

    point.position = (position / weights).cast<float>();
    point.sigma = static_cast<float>(scatter_of(views) / std::sqrt(weights));
    point.intensity = static_cast<float>(intensity / weights);
    const auto level = [&](double sum) { return grey_level(static_cast<float>(sum / weights)); };
    point.colour = {level(colour.x()), level(colour.y()), level(colour.z())};
    point.views = static_cast<std::uint16_t>(views.size());

    double low = views.front().height / views.front().weight, high = low;
    for (const ViewSums& sums : views) {
      low = std::min(low, sums.height / sums.weight);
      high = std::max(high, sums.height / sums.weight);
    }
    point.disagreement = static_cast<float>(high - low);
    return point;
  }

  const AllPoints& all_;
  float spacing_;
};

/// One of the points in each neighbourhood of half a spacing.
std::vector<ModelPoint> without_doubles(const std::vector<ModelPoint>& points, float spacing) {
  constexpr float nearest = 0.5F, least_alike = 0.5F;

  std::vector<Eigen::Vector3f> places;
  for (const ModelPoint& point : points) places.push_back(point.position);
  const PointGrid grid(places, 2 * spacing);  // few cells are looked up for each point

  std::vector<std::uint8_t> dropped(points.size());
  std::vector<ModelPoint> kept;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (dropped[i] != 0) continue;
    kept.push_back(points[i]);
    grid.for_each_near(places[i], nearest * spacing, [&](std::uint32_t k, float) {
      if (points[k].normal.dot(points[i].normal) > least_alike) dropped[k] = 1;
    });
  }
  return kept;
}

}  // namespace

ModelQuality quality_of(const FusedModel& model) {
  std::vector<double> sigmas, disagreements;
  for (const ModelPoint& point : model.points) {
    sigmas.push_back(point.sigma);
    if (point.views > 1) disagreements.push_back(point.disagreement);
  }

  ModelQuality quality{.median_sigma = median(std::move(sigmas))};
  if (!disagreements.empty()) quality.median_disagreement = median(std::move(disagreements));
  return quality;
}

ModelPoints model_points(const FusedModel& model) {
  const Size size{static_cast<int>(model.points.size()), 1};
  ModelPoints made{Cloud(size), {Image<float>(size), Image<float>(size), Image<float>(size)}};
  auto& [cloud, normals] = made;
  cloud.colour = Image<Colour>(model.coloured ? size : Size{});
  cloud.frame = model.frame;

  for (int i = 0; i < size.width; ++i) {
    const ModelPoint& point = model.points[static_cast<std::size_t>(i)];
    cloud.x(i, 0) = point.position.x();
    cloud.y(i, 0) = point.position.y();
    cloud.z(i, 0) = point.position.z();
    cloud.intensity(i, 0) = point.intensity;
    cloud.validity(i, 0) = Validity::valid;
    normals.x(i, 0) = point.normal.x();
    normals.y(i, 0) = point.normal.y();
    normals.z(i, 0) = point.normal.z();
    if (model.coloured) cloud.colour(i, 0) = point.colour;
  }
  return made;
}

void move_to_frame(FusedModel& model, const FramePose& pose) {
  model.frame = std::make_shared<const FramePose>(pose_from_frame(pose, camera_frame));
  const Eigen::Isometry3d& motion = model.frame->transform;
  for (ModelPoint& point : model.points) {
    point.position = (motion * point.position.cast<double>()).cast<float>();
    point.normal = (motion.linear() * point.normal.cast<double>()).cast<float>();
  }
}

FusedModel fuse(const std::vector<const View*>& views,
                const std::vector<std::optional<Eigen::Isometry3d>>& poses, float spacing) {
  // 1. All points in one frame.
  FusedModel model{.spacing = spacing, .coloured = true};
  std::vector<double> spacings;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!poses[i]) continue;
    model.coloured &= !views[i]->colours.empty();
    spacings.push_back(views[i]->spacing);
  }
  if (spacings.empty()) return model;
  if (!(model.spacing > 0)) model.spacing = static_cast<float>(median(spacings));
  const AllPoints all = collected(views, poses, model.coloured);

  // 2. An average around a point of each cell; cells that noise divides give doubles.
  const PointGrid grid(all.points, PointAverage::reach(model.spacing));
  const std::vector<std::uint32_t> seeds = thinned_to_cells(all.points, model.spacing);
  const PointAverage average(all, model.spacing);

  std::vector<int> seed_of(all.points.size(), -1);
  for (std::size_t k = 0; k < seeds.size(); ++k) seed_of[seeds[k]] = static_cast<int>(k);

  std::vector<ModelPoint> points(seeds.size());
  grid.for_each_cell([&](std::span<const std::uint32_t> inside, const NearPoints& near) {
    for (const std::uint32_t i : inside) {
      if (seed_of[i] >= 0) points[seed_of[i]] = average.at(i, near, model.coloured);
    }
  });

  std::erase_if(points, [](const ModelPoint& point) { return point.views == 0; });
  model.points = without_doubles(points, model.spacing);
  return model;
}

}  // namespace slipstream
