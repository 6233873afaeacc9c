#include "simulate/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "io/rig_file.h"
#include "slipstream/cleaner.h"
#include "slipstream/measure.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr double left_out = 0.003;

/// Width of the narrowest range with a share of the sorted `values`.
double narrowest_range(const std::vector<double>& values, double share) {
  const auto held = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));

  double width = values.back() - values.front();
  for (std::size_t i = 0; i + held <= values.size(); ++i) {
    width = std::min(width, values[i + held - 1] - values[i]);
  }

  return width;
}

/// That range, and half of how far it moves if the share moves by the standard deviation of the
/// share of as many random values.
Estimate narrowest_range_of(const std::vector<double>& values, double share) {
  const double sigma = std::sqrt(share * (1 - share) / static_cast<double>(values.size()));
  const double wider = narrowest_range(values, std::min(share + sigma, 1.0));
  const double narrower = narrowest_range(values, share - sigma);

  return {narrowest_range(values, share), (wider - narrower) / 2};
}

/// Crops a map to its finite values; it must have some.
Image<double> cropped(const Image<double>& map) {
  Eigen::AlignedBox2i held;
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    if (!std::isnan(map(column, row))) held.extend(Eigen::Vector2i(column, row));
  });

  const int left = held.min().x(), top = held.min().y();

  Image<double> part({held.sizes().x() + 1, held.sizes().y() + 1});
  for_each_pixel_in_order(
      part.size(), [&](int column, int row) { part(column, row) = map(left + column, top + row); });

  return part;
}

/// The cloud with only the points for which `belongs` is true.
template <class Belongs>
Cloud part_of(const Cloud& cloud, const Belongs& belongs) {
  Cloud part = cloud;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (!belongs(column, row)) part.reject(column, row, Validity::outside_region);
  });
  return part;
}

/// Fits the shape to a cloud and evaluates the deviations of its points.
template <class Fit>
auto measure_shape(const Cloud& cloud, const Fit& fit, ShapeAccuracy& accuracy) {
  const auto shape = fit(points_in(cloud), left_out);

  // The distance of each pixel's point from the shape.
  Image<double> map(cloud.size(), nan);
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    const auto point = point_at(cloud, nullptr, column, row);
    if (point) map(column, row) = signed_distance(shape, point->position);
  });

  std::vector<double> deviations = finite_values(map);
  std::ranges::sort(deviations);

  accuracy.range = narrowest_range_of(deviations, 1 - left_out);
  accuracy.range_95 = narrowest_range_of(deviations, 0.95);
  accuracy.rms = shape.residuals.rms;
  accuracy.points = deviations.size();

  for (const MeasuredPoint& point : points_in(cloud)) accuracy.extent.extend(point.position);
  accuracy.deviation = cropped(map);
  return shape;
}

/// Covariance, mm^2, of a fitted sphere's centre and radius, from independent deviations.
Eigen::Matrix4d covariance_of(const FittedSphere& sphere, const Cloud& cloud, double rms) {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  for (const MeasuredPoint& point : points_in(cloud)) {
    // Derivatives of minus the deviation, which is the distance from the centre minus the radius.
    Eigen::Vector4d derivatives;
    derivatives << (point.position - sphere.centre).normalized(), 1;
    information += derivatives * derivatives.transpose();
  }

  return rms * rms * information.inverse();
}

/// The standard uncertainty of a certified length, whose expanded one has a coverage factor of 2.
double standard_uncertainty(std::optional<double> expanded) {
  return expanded.value_or(0) / 2;
}

std::vector<ShapeAccuracy> measure_spheres(const Artefacts& artefacts, const Cloud& cloud) {
  std::vector<double> radii;
  for (const double diameter : artefacts.diameters) radii.push_back(diameter / 2);

  const std::vector<FittedSphere> found = find_spheres(cloud, radii);

  std::vector<ShapeAccuracy> accuracies(found.size());
  std::vector<FittedSphere> fitted;
  std::vector<Eigen::Matrix4d> covariances;
  for (std::size_t i = 0; i < found.size(); ++i) {
    // The two spheres of a bar are each other's partner; a single sphere is its own.
    const FittedSphere &here = found[i], &other = found[found.size() - 1 - i];
    const Eigen::Vector3d rod = (other.centre - here.centre).normalized();  // 0 for one sphere
    // Leave out steep points and points near the rod.
    const Cloud part = part_of(cloud, [&](int column, int row) {
      const Eigen::Vector3d point = position_at(cloud, column, row);
      return is_on_cap(here, point, 60 * degree) &&
             (point - here.centre).normalized().dot(rod) < std::cos(40 * degree);
    });

    fitted.push_back(measure_shape(part, fit_sphere, accuracies[i]));
    covariances.push_back(covariance_of(fitted[i], part, accuracies[i].rms));

    const double of_diameter = 2 * std::sqrt(covariances[i](3, 3));
    accuracies[i].size = {
        2 * fitted[i].radius - artefacts.diameters[i],
        std::hypot(of_diameter, standard_uncertainty(artefacts.diameter_uncertainty))};
  }

  if (!artefacts.distance) return accuracies;

  // The distance of the centres of a ball bar; only deviations along it change it.
  const Eigen::Vector3d line = fitted[1].centre - fitted[0].centre;
  const Eigen::Vector3d along = line.normalized();
  const Eigen::Matrix3d of_centres =
      covariances[0].topLeftCorner<3, 3>() + covariances[1].topLeftCorner<3, 3>();
  accuracies[1].spacing = {line.norm() - *artefacts.distance,
                           std::hypot(std::sqrt(along.dot(of_centres * along)),
                                      standard_uncertainty(artefacts.distance_uncertainty))};
  return accuracies;
}

/// RMS of the means over square blocks of pixels with enough values.
Estimate rms_of_means(const Image<double>& map) {
  constexpr int side = 16, least = side * side / 2;

  double squares = 0;
  int means = 0;

  for_each_pixel_in_order({map.width() / side, map.height() / side}, [&](int column, int row) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < side * side; ++i) {
      const double value = map(side * column + i % side, side * row + i / side);
      if (std::isnan(value)) continue;
      sum += value;
      ++count;
    }
    // Blocks with less than half of their pixels say little.
    if (count < least) return;

    squares += sum / count * sum / count;
    ++means;
  });

  const double rms = std::sqrt(squares / means);
  return {rms, rms / std::sqrt(2.0 * means)};
}

ShapeAccuracy measure_plane(const Cloud& cloud) {
  // 1. A rough plane, and its length from the median distance of the points: see the header.
  const std::vector<MeasuredPoint> points = points_in(cloud);
  const FittedPlane rough = fit_plane(points);
  const double reach = median_of(
      points, [&](const MeasuredPoint& point) { return (point.position - rough.centre).norm(); });
  const double length = 2.5 * reach;

  // 2. The largest connected piece near that plane.
  Cloud whole = part_of(cloud, [&](int column, int row) {
    return std::abs(signed_distance(rough, position_at(cloud, column, row))) < 0.01 * length;
  });
  CleanSettings largest_piece = CleanSettings::none();
  largest_piece.smallest_component = static_cast<int>(point_count(whole) / 2);
  Cleaner{largest_piece}(whole);

  // 3. Without the rim.
  constexpr int rim = 5;
  const Cloud inner = part_of(whole, [&](int column, int row) {
    const auto has_point = [&](int right, int down) {
      return point_at(whole, nullptr, column + right, row + down).has_value();
    };
    return has_point(0, 0) && has_point(-rim, 0) && has_point(rim, 0) && has_point(0, -rim) &&
           has_point(0, rim);
  });

  ShapeAccuracy accuracy;
  measure_shape(inner, fit_plane, accuracy);

  accuracy.bending = rms_of_means(accuracy.deviation);
  return accuracy;
}

/// Mean and sum of squared deviations of Z by pixel, updated scan by scan.
struct Spread {
  Image<double> mean, squares;
  int scans = 0;

  void add(const Image<float>& z) {
    if (scans == 0) mean = squares = Image<double>(z.size());
    if (z.size() != mean.size()) throw Error("its size differs from the first scan's");
    ++scans;

    // Welford's update of mean and squares.
    for (std::size_t i = 0; i < z.pixel_count(); ++i) {
      const double step = static_cast<double>(z.begin()[i]) - mean.begin()[i];
      mean.begin()[i] += step / scans;
      squares.begin()[i] += step * step * (scans - 1) / scans;
    }
  }
};

Repeatability repeatability(const Spread& spread) {
  Repeatability result{spread.scans, spread.squares};
  for (double& value : result.sigma) value = std::sqrt(value / (spread.scans - 1));

  std::vector<double> sigmas = finite_values(result.sigma);
  if (sigmas.empty()) throw Error("repeated: no pixel has a point in all scans");
  if (quantile(sigmas, 0.5) == 0) throw Error("repeated: the scans are copies of each other");

  result.sigma = cropped(result.sigma);
  return result;
}

/// Every figure, in the order of the report.
constexpr std::array all_figures{
    AccuracyFigure{"probing_form", "probing error of form, 99.7 % of the points",
                   "VDI/VDE 2634-2: P_F"},
    AccuracyFigure{"probing_form_95", "probing error of form, 95 % of the points",
                   "as in ISO 10360-13"},
    AccuracyFigure{"probing_size", "probing error of size", "VDI/VDE 2634-2: P_S"},
    AccuracyFigure{"sphere_spacing", "sphere-spacing error", "VDI/VDE 2634-2: S_D"},
    AccuracyFigure{"dimension", "dimension trueness: mean of sphere-spacing errors", ""},
    AccuracyFigure{"flatness", "flatness error, 99.7 % of the points", "VDI/VDE 2634-2: flatness"},
    AccuracyFigure{"flatness_95", "flatness error, 95 % of the points", "as in ISO 10360-13"},
    AccuracyFigure{"planarity", "planarity trueness: RMS of means over 16x16 pixels", ""},
    AccuracyFigure{"precision", "precision: sigma of Z by pixel, median", ""}};

/// The mean of a figure over the positions.
Estimate mean_of(const std::vector<Estimate>& positions) {
  double sum = 0, squares = 0;
  for (const Estimate& position : positions) {
    sum += position.value;
    squares += position.uncertainty * position.uncertainty;
  }

  const auto count = static_cast<double>(positions.size());
  return {sum / count, std::sqrt(squares) / count};
}

/// The median of the pixels' sigmas. Each has a relative uncertainty of 1 / sqrt(2 (n - 1)) of n
/// scans, and a median of N values 1.25 / sqrt(N) of theirs.
Estimate precision_of(const Repeatability& repeated) {
  std::vector<double> sigmas = finite_values(repeated.sigma);
  const double median = quantile(sigmas, 0.5);
  const double of_each = median / std::sqrt(2.0 * (repeated.scans - 1));

  return {median, 1.25 * of_each / std::sqrt(static_cast<double>(sigmas.size()))};
}

/// Compares the figures with their limits.
Verdict verdict_of_limits(const std::vector<AccuracyFigure>& figures) {
  std::vector<std::string> failed;
  int limits = 0;
  for (const AccuracyFigure& figure : figures) {
    if (figure.limit) ++limits;
    if (!figure.fails()) continue;
    failed.push_back(fmt::format("{} is {:.4f} mm, its limit {:g} mm", figure.what,
                                 figure.measured.value, *figure.limit));
  }

  if (!failed.empty()) {
    return {"bad", fmt::format("Failed: {}.", fmt::join(failed, "; "))};
  }
  return {"good", limits == 1 ? "Passed: the figure is within its limit."
                              : fmt::format("Passed: {} figures are within their limits.", limits)};
}

double value_of(const std::optional<Estimate>& estimate) {
  return estimate ? estimate->value : 0;
}

/// Compares the worst systematic error with the random deviations of its position.
Verdict verdict_of_errors(const Accuracy& accuracy, bool exact_scanner) {
  double worst = 0, error = 0, noise = 0;  // the worst ratio; mm
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    // Bending is the systematic part of the plane's deviations; the rest is random.
    const double bending = value_of(shape.bending);
    const double systematic =
        std::max({std::abs(value_of(shape.size)), std::abs(value_of(shape.spacing)), bending});
    const double random = std::sqrt(std::max(shape.rms * shape.rms - bending * bending, 1e-12));

    if (systematic / random < worst) continue;
    worst = systematic / random;
    error = systematic;
    noise = random;
  }

  // Random errors dominate up to a ratio of 1; above 3 a new calibration is worth it.
  const std::string sizes =
      fmt::format("systematic errors up to {:.3f} mm, random errors {:.3f} mm", error, noise);
  if (accuracy.shapes.empty() || worst <= 1) return {"good", "Good: " + sizes + "."};

  if (exact_scanner) {
    return {"usable", "Usable: " + sizes +
                          "; the scanner is exact, so they come from blur, noise and gamma: more "
                          "steps and narrower fringes reduce them."};
  }

  if (worst <= 3) return {"usable", "Usable: " + sizes + "; a new calibration may be better."};
  return {"bad", "Do again: " + sizes + "; calibrate geometry and gamma again."};
}

}  // namespace

Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of) {
  Accuracy accuracy;
  Spread spread;

  // Measures each of the scans; errors carry the scan's name.
  const auto visit = [&](const std::vector<std::string>& scans, const auto& measure) {
    for (const std::string& scan : scans) {
      const Cloud cloud = cloud_of(scan);
      for (ShapeAccuracy& shape : naming(scan, [&] { return measure(cloud); })) {
        shape.scan = scan;
        accuracy.shapes.push_back(std::move(shape));
      }
    }
  };

  using Shapes = std::vector<ShapeAccuracy>;
  visit(artefacts.spheres, [&](const Cloud& cloud) { return measure_spheres(artefacts, cloud); });
  visit(artefacts.planes, [&](const Cloud& cloud) { return Shapes{measure_plane(cloud)}; });
  // Repeated scans only add to the spread.
  visit(artefacts.repeated, [&](const Cloud& cloud) {
    spread.add(cloud.z);
    return Shapes{};
  });

  if (spread.scans > 1) accuracy.repeated = repeatability(spread);
  return accuracy;
}

std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy) {
  std::map<std::string_view, Estimate> measured;

  // 1. Keeps the value farthest from 0 of all positions.
  const auto take = [&](std::string_view key, const Estimate& estimate) {
    const auto [kept, first] = measured.try_emplace(key, estimate);
    if (std::abs(estimate.value) > std::abs(kept->second.value)) kept->second = estimate;
  };

  // 2. Spheres have a size, planes have none; only a ball bar has a spacing.
  std::vector<Estimate> spacings;
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    take(shape.size ? "probing_form" : "flatness", shape.range);
    take(shape.size ? "probing_form_95" : "flatness_95", shape.range_95);
    if (shape.size) take("probing_size", *shape.size);
    if (shape.bending) take("planarity", *shape.bending);
    if (!shape.spacing) continue;
    take("sphere_spacing", *shape.spacing);
    spacings.push_back(*shape.spacing);
  }

  // 3. Means and medians over all positions.
  if (!spacings.empty()) measured["dimension"] = mean_of(spacings);
  if (accuracy.repeated) measured["precision"] = precision_of(*accuracy.repeated);

  std::vector<AccuracyFigure> figures;
  for (AccuracyFigure figure : all_figures) {
    const auto found = measured.find(figure.key);
    if (found == measured.end()) continue;
    figure.measured = found->second;
    figures.push_back(figure);
  }

  return figures;
}

std::vector<std::string> accuracy_keys() {
  std::vector<std::string> keys;
  for (const AccuracyFigure& figure : all_figures) keys.emplace_back(figure.key);
  return keys;
}

void set_limits(std::vector<AccuracyFigure>& figures,
                const std::vector<std::pair<std::string, double>>& limits) {
  for (const auto& [key, limit] : limits) {
    const auto figure = std::ranges::find(figures, key, &AccuracyFigure::key);
    throw_if(figure == figures.end(), "a limit is set for {}, but no scan measures it", key);
    figure->limit = limit;
  }
}

Verdict verdict_of(const Accuracy& accuracy, const std::vector<AccuracyFigure>& figures,
                   bool exact_scanner) {
  const bool has_limits =
      std::ranges::any_of(figures, [](const AccuracyFigure& f) { return f.limit.has_value(); });
  return has_limits ? verdict_of_limits(figures) : verdict_of_errors(accuracy, exact_scanner);
}

}  // namespace slipstream
