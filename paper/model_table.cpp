#include "paper/model_table.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "cloud/object_model.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

/// Signed distances of a model's points from the scene's surfaces along the points' normals, mm;
/// infinite if there is no surface.
std::vector<double> distances_from(const Scene& scene, const ModelPoints& model) {
  constexpr double reach = 5;
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  std::vector<double> distances;
  for (int i = 0; i < model.cloud.size().width; ++i) {
    const Eigen::Vector3d point(model.cloud.x(i, 0), model.cloud.y(i, 0), model.cloud.z(i, 0));
    const Eigen::Vector3d normal(model.normals.x(i, 0), model.normals.y(i, 0),
                                 model.normals.z(i, 0));
    const auto surface = first_surface(bodies, {point + reach * normal, -normal});
    const double distance = surface ? reach - surface->distance : INFINITY;
    distances.push_back(std::abs(distance) < reach ? distance : INFINITY);
  }
  return distances;
}

Reproduction model_table(std::uint64_t seed) {
  constexpr int views = 360;
  constexpr double flying = 1;  // mm
  const Scanner scanner = example_scanner();
  Scene scene = scene_named("statue", scanner);
  std::erase_if(scene, [](const Body& body) { return body.fixed; });
  const Motion turntable{.turn = {0, 2 * std::numbers::pi / views, 0},
                         .centre = working_volume(scanner).centre};
  const Sequence sequence{.strategy = DualFrequency{.steps = 4, .high = 32, .low = 1}};
  Engine engine(scanner, sequence);
  ObjectModel model(scanner.camera);
  Cloud cloud;
  for (int view = 0; view < views; ++view) {
    Scene turned = scene;
    turned.front().pose = Eigen::Isometry3d(turntable.at(view).matrix()) * turned.front().pose;
    const Photometry photometry{.noise_variance = 1.55, .seed = seed + view};
    engine.cloud(take_scan(scanner, turned, pattern_set(sequence), photometry).frames, cloud);
    (void)model.add(cloud, view);
  }
  const ModelPoints points = model.points();
  const std::vector<double> distances = distances_from(scene, points);
  double near = 0, sum = 0, squares = 0;
  for (const double distance : distances) {
    if (!(std::abs(distance) < flying)) continue;
    ++near;
    sum += distance;
    squares += distance * distance;
  }
  const auto all = static_cast<double>(distances.size());
  const Eigen::Matrix3d off =
      model.registration().pose.linear() * turntable.at(views - 1).linear().transpose();
  Reproduction result;
  const auto add = [&](std::string what, double value) {
    result.add(std::move(what), {}, std::nullopt, std::nullopt, value);
  };
  add("views merged", model.views());
  add("points", all);
  add("RMS error, mm", std::sqrt(squares / near));
  add("mean error, mm", sum / near);
  add("points off by more than 1 mm, %", 100 * (all - near) / all);
  add("rotation error of the last view, degrees",
      Eigen::AngleAxisd(off).angle() * 180 / std::numbers::pi);
  result.notes.emplace_back(
      "Compared with the statue at its position in the first view, over points within 1 mm. "
      "640x480, noise variance 1.55.");
  return result;
}

}  // namespace

std::vector<Reproducible> model_reproducibles() {
  return {{"experiment", "model", "one model of a statue from 360 views", model_table}};
}

}  // namespace slipstream
