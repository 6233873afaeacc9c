#include "slipstream/accuracy/accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/cloud/measure.h"
#include "slipstream/cloud/spheres.h"
#include "slipstream/error/error.h"
#include "slipstream/image/quantile.h"

namespace slipstream {
namespace {

constexpr double left_out = 0.003;
constexpr double degree = std::numbers::pi / 180;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The width of the narrowest range that holds a share of the values.
double narrowest_range(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto held = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  double width = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + held <= values.size(); ++i) {
    width = std::min(width, values[i + held - 1] - values[i]);
  }
  return width;
}

template <class Shape>
FormDeviation form_of(const Shape& shape, const std::vector<MeasuredPoint>& points) {
  std::vector<double> deviations;
  for (const MeasuredPoint& point : points) {
    deviations.push_back(signed_distance(shape, point.position));
  }
  return {.range = narrowest_range(deviations, 1 - left_out),
          .dispersion = narrowest_range(deviations, 0.95),
          .rms = shape.residuals.rms,
          .points = points.size()};
}

/// Writes what the points deviate from the shape into the map.
template <class Shape>
void draw(const Shape& shape, const Cloud& cloud, const std::vector<MeasuredPoint>& points,
          Image<double>& map) {
  auto point = points.begin();  // in the order of the pixels
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width() && point != points.end(); ++column) {
      const auto here = point_at(cloud, nullptr, column, row);
      if (!here || here->position != point->position) continue;
      map(column, row) = signed_distance(shape, (point++)->position);
    }
  }
}

/// Leaves out what the rod to the other sphere may hide or touch.
void leave_out_rod(std::vector<MeasuredPoint>& points, const FittedSphere& sphere,
                   const FittedSphere& other) {
  const double widest = std::cos(40 * degree);
  const Eigen::Vector3d rod = (other.centre - sphere.centre).normalized();
  std::erase_if(points, [&](const MeasuredPoint& point) {
    return (point.position - sphere.centre).normalized().dot(rod) > widest;
  });
}

SpheresAccuracy measure_spheres(const Artefacts& artefacts, const Cloud& cloud,
                                Image<double>& map) {
  std::vector<double> radii;
  for (const double diameter : artefacts.diameters) radii.push_back(diameter / 2);
  std::vector<FittedSphere> spheres = find_spheres(cloud, radii);
  const std::vector<FittedSphere> found = spheres;
  SpheresAccuracy result;
  for (std::size_t i = 0; i < found.size(); ++i) {
    std::vector<MeasuredPoint> points = points_on(cloud, found[i], 60 * degree);
    if (found.size() == 2) leave_out_rod(points, found[i], found[1 - i]);
    spheres[i] = fit_sphere_leaving_out(points, left_out);
    result.spheres.push_back({.size = 2 * spheres[i].radius - artefacts.diameters[i],
                              .form = form_of(spheres[i], points)});
    draw(spheres[i], cloud, points, map);
  }
  if (artefacts.distance) {
    result.spacing = (spheres[1].centre - spheres[0].centre).norm() - *artefacts.distance;
  }
  return result;
}

/// RMS of the means of blocks that hold enough values.
double rms_of_blocks(const Image<double>& map) {
  constexpr int side = 16, least = side * side / 2;
  double squares = 0;
  int blocks = 0;
  for (int top = 0; top < map.height(); top += side) {
    for (int left = 0; left < map.width(); left += side) {
      double sum = 0;
      int count = 0;
      for (int row = top; row < std::min(top + side, map.height()); ++row) {
        for (int column = left; column < std::min(left + side, map.width()); ++column) {
          if (std::isnan(map(column, row))) continue;
          sum += map(column, row);
          ++count;
        }
      }
      if (count < least) continue;
      squares += sum / count * sum / count;
      ++blocks;
    }
  }
  return blocks > 0 ? std::sqrt(squares / blocks) : nan;
}

PlaneAccuracy measure_plane(const Cloud& cloud, Image<double>& map) {
  std::vector<MeasuredPoint> points =
      points_in(cloud, nullptr, {.x = 0, .y = 0, .size = cloud.size()});
  const FittedPlane rough = fit_plane(points);
  double length = 0;
  for (const MeasuredPoint& point : points) {
    length = std::max(length, 2 * (point.position - rough.centre).norm());
  }
  std::erase_if(points, [&](const MeasuredPoint& point) {
    return std::abs(signed_distance(rough, point.position)) > 0.01 * length;
  });
  const FittedPlane plane = fit_plane_leaving_out(points, left_out);
  draw(plane, cloud, points, map);
  return {.scan = {}, .form = form_of(plane, points), .bending = rms_of_blocks(map)};
}

/// Keeps the map if its scan is the worst so far.
void keep_worst(double error, const std::string& scan, Image<double>& map, double& worst,
                DeviationMap& kept) {
  if (error <= worst) return;
  worst = error;
  kept = {scan, std::move(map)};
}

/// Mean and sum of squared deviations of Z by pixel, which grow scan by scan.
struct Spread {
  Image<double> mean, squares;
  int scans = 0;

  void add(const Image<float>& z) {
    if (scans == 0) mean = squares = Image<double>(z.size());
    if (z.size() != mean.size()) throw Error("it is of another size than the first");
    ++scans;
    for (std::size_t i = 0; i < z.pixel_count(); ++i) {
      const double step = static_cast<double>(z.begin()[i]) - mean.begin()[i];
      mean.begin()[i] += step / scans;
      squares.begin()[i] += step * (static_cast<double>(z.begin()[i]) - mean.begin()[i]);
    }
  }
};

RepeatAccuracy repeat_accuracy(const Spread& spread, Image<double>& sigma) {
  sigma = spread.squares;
  for (double& value : sigma) value = std::sqrt(value / (spread.scans - 1));
  std::vector<double> values = finite_values(sigma);
  if (values.empty()) throw Error("repeated: no pixel has a point in all scans");
  const double middle = quantile(values, 0.5);
  if (middle == 0) throw Error("repeated: the scans are copies of one");
  return {.scans = spread.scans, .pixels = values.size(), .sigma = middle};
}

/// Does what is done with each scan's cloud; what it throws names the scan.
void for_each_cloud(const std::vector<std::string>& scans, const CloudOfScan& cloud_of,
                    const std::function<void(const std::string&, const Cloud&)>& work) {
  for (const std::string& scan : scans) {
    const Cloud cloud = cloud_of(scan);
    try {
      work(scan, cloud);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", scan, error.what()));
    }
  }
}

}  // namespace

Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of) {
  Accuracy accuracy;
  double worst = 0;
  for_each_cloud(artefacts.spheres, cloud_of, [&](const std::string& scan, const Cloud& cloud) {
    Image<double> map(cloud.size(), nan);
    SpheresAccuracy found = measure_spheres(artefacts, cloud, map);
    found.scan = scan;
    double form = 0;
    for (const SphereAccuracy& sphere : found.spheres) form = std::max(form, sphere.form.range);
    keep_worst(form, scan, map, worst, accuracy.worst_spheres);
    accuracy.spheres.push_back(std::move(found));
  });
  worst = 0;
  for_each_cloud(artefacts.planes, cloud_of, [&](const std::string& scan, const Cloud& cloud) {
    Image<double> map(cloud.size(), nan);
    PlaneAccuracy found = measure_plane(cloud, map);
    found.scan = scan;
    keep_worst(found.form.range, scan, map, worst, accuracy.worst_plane);
    accuracy.planes.push_back(std::move(found));
  });
  Spread spread;
  for_each_cloud(artefacts.repeated, cloud_of,
                 [&](const std::string& /*scan*/, const Cloud& cloud) { spread.add(cloud.z); });
  if (spread.scans > 1) accuracy.repeated = repeat_accuracy(spread, accuracy.repeat_sigma);
  return accuracy;
}

std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy, const Artefacts& artefacts) {
  std::vector<AccuracyFigure> figures{
      {"probing_form", "probing error, form: 99.7 % of the points"},
      {"probing_form_95", "probing error, form: 95 % of the points"},
      {"probing_size", "probing error, size"},
      {"sphere_spacing", "sphere-spacing error"},
      {"flatness", "flatness error: 99.7 % of the points"},
      {"flatness_95", "flatness error: 95 % of the points"},
      {"bending", "planarity trueness: RMS of means over 16x16 pixels"},
      {"precision", "precision: sigma of Z by pixel, median"}};
  for (AccuracyFigure& figure : figures) figure.millimetres = nan;
  const auto take = [&](std::size_t figure, double value) {
    double& worst = figures[figure].millimetres;
    if (!(std::abs(value) <= std::abs(worst))) worst = value;
  };
  for (const SpheresAccuracy& position : accuracy.spheres) {
    for (const SphereAccuracy& sphere : position.spheres) {
      take(0, sphere.form.range);
      take(1, sphere.form.dispersion);
      take(2, sphere.size);
    }
    if (position.spacing) take(3, *position.spacing);
  }
  for (const PlaneAccuracy& plane : accuracy.planes) {
    take(4, plane.form.range);
    take(5, plane.form.dispersion);
    take(6, plane.bending);
  }
  if (accuracy.repeated) take(7, accuracy.repeated->sigma);
  std::erase_if(figures, [](const auto& figure) { return std::isnan(figure.millimetres); });
  for (AccuracyFigure& figure : figures) {
    figure.share = figure.millimetres / artefacts.diagonal.value_or(nan);
  }
  return figures;
}

std::optional<double> scale_error(const Accuracy& accuracy, const Artefacts& artefacts) {
  if (!artefacts.distance || accuracy.spheres.empty()) return std::nullopt;
  double sum = 0;
  for (const SpheresAccuracy& position : accuracy.spheres) sum += position.spacing.value_or(0);
  return sum / static_cast<double>(accuracy.spheres.size()) / *artefacts.distance;
}

}  // namespace slipstream
