#include "slipstream/cloud/measure.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/scan_input.h"
#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"

namespace slipstream::app {
namespace {

struct MeasureFlags {
  std::string path;
  CloudInputFlags input;
  std::vector<std::string> points, planes, spheres;
  std::vector<std::pair<std::string, std::string>> distances;
};

/// What is measured in, and where the words go.
struct Measuring {
  const StoredCloud& stored;
  Output& output;

  [[nodiscard]] const Uncertainty* uncertainty() const {
    return stored.uncertainty ? &*stored.uncertainty : nullptr;
  }
};

struct Pixel {
  int column = 0, row = 0;
};

Pixel pixel_from(const std::string& text) {
  const std::vector<int> numbers = numbers_in<int>(text, ',');
  if (numbers.size() != 2) {
    throw Error(fmt::format("'{}' is no pixel; give column and row, as 320,240", text));
  }
  return {numbers[0], numbers[1]};
}

MeasuredPoint point_of(const Measuring& in, const std::string& text) {
  const auto [column, row] = pixel_from(text);
  const Cloud& cloud = in.stored.cloud;
  if (const auto point = point_at(cloud, in.uncertainty(), column, row)) return *point;
  const bool inside =
      column >= 0 && row >= 0 && column < cloud.size().width && row < cloud.size().height;
  throw Error(
      inside ? fmt::format("pixel {} has no point: {}", text, name_of(cloud.validity(column, row)))
             : fmt::format("pixel {} is not in the picture, which is {}", text,
                           text_of(cloud.size())));
}

std::vector<MeasuredPoint> points_of(const Measuring& in, const std::string& text) {
  const std::optional<Rectangle> rectangle = rectangle_of_text(text);
  if (!rectangle) {
    throw Error(
        fmt::format("'{}' is no rectangle; give width x height + x + y, as 200x100+320+240", text));
  }
  return points_in(in.stored.cloud, in.uncertainty(), *rectangle);
}

nlohmann::json json_of(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

std::string text_of(const Eigen::Vector3d& vector) {
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", vector.x(), vector.y(), vector.z());
}

void measure_point(const std::string& pixel, const Measuring& in) {
  const MeasuredPoint point = point_of(in, pixel);
  nlohmann::json told{{"pixel", pixel}, {"position_mm", json_of(point.position)}};
  if (point.sigma) told["sigma_mm"] = json_of(*point.sigma);
  in.output.list("points").push_back(std::move(told));
  in.output.say("point {}: {} mm{}", pixel, text_of(point.position),
                point.sigma ? fmt::format(", sigma {} mm", text_of(*point.sigma)) : "");
}

void measure_distance(const std::pair<std::string, std::string>& pixels, const Measuring& in) {
  const Distance apart = distance(point_of(in, pixels.first), point_of(in, pixels.second));
  nlohmann::json told{{"from", pixels.first}, {"to", pixels.second}, {"length_mm", apart.length}};
  if (apart.sigma) told["sigma_mm"] = *apart.sigma;
  in.output.list("distances").push_back(std::move(told));
  in.output.say("distance {} to {}: {:.3f} mm{}", pixels.first, pixels.second, apart.length,
                apart.sigma ? fmt::format(", sigma {:.3f} mm", *apart.sigma) : "");
}

/// Adds the residuals to what is told of a shape, in words too.
void tell_fit(const char* list, nlohmann::json told, const Residuals& residuals, Output& output) {
  told.update({{"rms_mm", residuals.rms},
               {"largest_mm", residuals.largest},
               {"points", residuals.points},
               {"outliers", residuals.outliers}});
  if (residuals.noise) told["noise_mm"] = *residuals.noise;
  output.list(list).push_back(std::move(told));
  output.say("  residuals of {} points: rms {:.4f} mm{}, largest {:.4f} mm; {} outliers left out",
             residuals.points, residuals.rms,
             residuals.noise ? fmt::format(" (noise alone: {:.4f})", *residuals.noise) : "",
             residuals.largest, residuals.outliers);
}

void measure_plane(const std::string& rectangle, const Measuring& in) {
  const FittedPlane plane = fit_plane(points_of(in, rectangle));
  in.output.say("plane in {}: through {} mm, normal {}", rectangle, text_of(plane.centre),
                text_of(plane.normal));
  tell_fit("planes",
           {{"rectangle", rectangle},
            {"centre_mm", json_of(plane.centre)},
            {"normal", json_of(plane.normal)}},
           plane.residuals, in.output);
}

void measure_sphere(const std::string& rectangle, const Measuring& in) {
  const FittedSphere sphere = fit_sphere(points_of(in, rectangle));
  in.output.say("sphere in {}: radius {:.4f} mm, sigma {:.4f} mm, centre {} mm", rectangle,
                sphere.radius, sphere.radius_sigma, text_of(sphere.centre));
  tell_fit("spheres",
           {{"rectangle", rectangle},
            {"centre_mm", json_of(sphere.centre)},
            {"radius_mm", sphere.radius},
            {"radius_sigma_mm", sphere.radius_sigma}},
           sphere.residuals, in.output);
}

void measure(const MeasureFlags& flags, Output& output) {
  if (flags.points.empty() && flags.distances.empty() && flags.planes.empty() &&
      flags.spheres.empty()) {
    throw Error("nothing to measure; give --point, --distance, --plane or --sphere");
  }
  output.document["input"] = flags.path;
  const StoredCloud stored = organised_cloud(flags.path, flags.input, output);
  const Measuring in{stored, output};
  for (const auto& pixel : flags.points) measure_point(pixel, in);
  for (const auto& pixels : flags.distances) measure_distance(pixels, in);
  for (const auto& rectangle : flags.planes) measure_plane(rectangle, in);
  for (const auto& rectangle : flags.spheres) measure_sphere(rectangle, in);
}

}  // namespace

void add_measure(CLI::App& program, Command& chosen) {
  const auto [command, flags] = add_command(program, chosen, measure, "measure",
                                            "points, distances, planes and spheres of a cloud, mm");
  command.add_file("input", flags.path, "a scan folder, a recording or an organised cloud, .pcd")
      ->required();
  const FlagGroup group{command.app, "What to measure, each as often as wanted"};
  group.add("--point", flags.points, "the point of a pixel, column and row, as 320,240");
  group.add("--distance", flags.distances, "between the points of two pixels: 320,240 400,250");
  group.add("--plane", flags.planes,
            "fitted to the points of a rectangle of pixels, width x height + x + y, as "
            "200x100+320+240");
  group.add("--sphere", flags.spheres, "likewise");
  add_cloud_input_flags(command.app, flags.input);
  command.app.footer(
      "Examples:\n  slipstream measure scan --point 320,240 --distance 100,200 500,210\n"
      "  slipstream measure cloud.pcd --plane 200x100+320+240 --json");
}

}  // namespace slipstream::app
