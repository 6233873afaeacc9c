#include "simulate/accuracy.h"

#include <algorithm>
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

  accuracy.range = narrowest_range(deviations, 1 - left_out);
  accuracy.range_95 = narrowest_range(deviations, 0.95);
  accuracy.rms = shape.residuals.rms;
  accuracy.points = deviations.size();

  accuracy.deviation = cropped(map);
  return shape;
}

std::vector<ShapeAccuracy> measure_spheres(const Artefacts& artefacts, const Cloud& cloud) {
  std::vector<double> radii;
  for (const double diameter : artefacts.diameters) radii.push_back(diameter / 2);

  const std::vector<FittedSphere> found = find_spheres(cloud, radii);

  std::vector<ShapeAccuracy> accuracies(found.size());
  std::vector<FittedSphere> fitted;
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
    accuracies[i].size = 2 * fitted[i].radius - artefacts.diameters[i];
  }

  if (artefacts.distance) {
    accuracies[1].spacing = (fitted[1].centre - fitted[0].centre).norm() - *artefacts.distance;
  }

  return accuracies;
}

/// RMS of the means over square blocks of pixels with enough values.
double rms_of_means(const Image<double>& map) {
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

  return std::sqrt(squares / means);
}

ShapeAccuracy measure_plane(const Cloud& cloud) {
  // 1. A rough plane, and its length from the median distance of the points: see the header.
  const std::vector<MeasuredPoint> points = points_in(cloud);
  const FittedPlane rough = fit_plane(points);
  std::vector<double> reaches;
  for (const MeasuredPoint& point : points) {
    reaches.push_back((point.position - rough.centre).norm());
  }
  const double length = 2.5 * quantile(reaches, 0.5);

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

double length_from(const std::string& text) {
  constexpr double longest = 1e6;
  const auto length = number_in<double>(text);
  throw_if(!length || !(*length > 0) || *length > longest, "'{}': expected a length, 0 to {:g} mm",
           text, longest);
  return *length;
}

double one_length_from(const std::vector<std::string>& values) {
  if (values.size() != 1) throw Error("expected one length");
  return length_from(values.front());
}

void take(const RigSetting& setting, const fs::path& folder, Artefacts& artefacts) {
  // The lists of scans, by their names in the file.
  const std::map<std::string, std::vector<std::string>*> scans{{"spheres", &artefacts.spheres},
                                                               {"planes", &artefacts.planes},
                                                               {"repeated", &artefacts.repeated}};

  if (const auto kind = scans.find(setting.name); kind != scans.end()) {
    for (const std::string& scan : setting.values) kind->second->push_back(folder / scan);
  } else if (setting.name == "diameters") {
    for (const std::string& text : setting.values) artefacts.diameters.push_back(length_from(text));
  } else if (setting.name == "distance") {
    artefacts.distance = one_length_from(setting.values);
  } else if (setting.name == "diagonal") {
    artefacts.diagonal = one_length_from(setting.values);
  } else {
    const std::vector<std::string> known{"diameters", "distance", "spheres",
                                         "planes",    "repeated", "diagonal"};
    throw Error(fmt::format("not known; expected one of: {}{}", fmt::join(known, ", "),
                            did_you_mean(setting.name, known)));
  }
}

/// The first inconsistency, or an empty string.
std::string fault_of(const Artefacts& artefacts) {
  const std::size_t spheres = artefacts.diameters.size();
  if (spheres > 2) return "diameters: expected one or two";

  if (artefacts.distance.has_value() != (spheres == 2)) {
    return "two diameters require the distance of their spheres, and a distance two diameters";
  }

  if (artefacts.spheres.empty() != (spheres == 0)) {
    return "diameters require scans of spheres, and scans of spheres diameters";
  }

  if (artefacts.repeated.size() == 1) return "repeated: expected two scans or more";

  const bool none =
      artefacts.spheres.empty() && artefacts.planes.empty() && artefacts.repeated.empty();
  return none ? "no scans are listed" : "";
}

std::string cell(std::optional<double> value) {
  return value ? fmt::format("{:.4f}", *value) : "";
}

/// Pictures of the sphere and the plane with the largest form error, and of the repeated scans.
void write_pictures(Page& page, const fs::path& folder, const Accuracy& accuracy) {
  const auto add = [&](const std::string& says, const char* file, const Image<double>& map) {
    write_map_preview(folder / file, map, "mm");
    page.picture(says, file);
  };

  // The worst sphere and the worst plane, by form error. Only spheres have a size.
  const ShapeAccuracy *sphere = nullptr, *plane = nullptr;
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    const ShapeAccuracy*& worst = shape.size ? sphere : plane;
    if (worst == nullptr || shape.range > worst->range) worst = &shape;
  }

  if (sphere != nullptr) add("deviations: " + sphere->scan, "sphere.png", sphere->deviation);
  if (plane != nullptr) add("deviations: " + plane->scan, "plane.png", plane->deviation);

  if (accuracy.repeated) {
    add(fmt::format("sigma of Z over {} scans", accuracy.repeated->scans), "repeated.png",
        accuracy.repeated->sigma);
  }
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
  AccuracyFigure form{"probing_form", "probing error of form P_F, 99.7 % of the points", nan};
  AccuracyFigure form_95{"probing_form_95", "probing error of form, 95 % of the points", nan};
  AccuracyFigure size{"probing_size", "probing error of size P_S", nan};
  AccuracyFigure spacing{"sphere_spacing", "sphere-spacing error S_D", nan};
  AccuracyFigure dimension{"dimension", "dimension trueness: mean of sphere-spacing errors", nan};
  AccuracyFigure flat{"flatness", "flatness error, 99.7 % of the points", nan};
  AccuracyFigure flat_95{"flatness_95", "flatness error, 95 % of the points", nan};
  AccuracyFigure bending{"planarity", "planarity trueness: RMS of means over 16x16 pixels", nan};
  AccuracyFigure precision{"precision", "precision: sigma of Z by pixel, median", nan};

  // Keeps the value farthest from 0; NaN counts as none.
  const auto take = [](AccuracyFigure& figure, double value) {
    if (!(std::abs(value) <= std::abs(figure.value))) figure.value = value;
  };

  // Spheres have a size, planes have none.
  double sum = 0;
  int distances = 0;
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    take(shape.size ? form : flat, shape.range);
    take(shape.size ? form_95 : flat_95, shape.range_95);
    if (shape.size) take(size, *shape.size);
    if (shape.bending) take(bending, *shape.bending);

    // Only a ball bar has a spacing.
    if (!shape.spacing) continue;
    take(spacing, *shape.spacing);
    sum += *shape.spacing;
    dimension.value = sum / ++distances;
  }

  if (accuracy.repeated) {
    std::vector<double> sigmas = finite_values(accuracy.repeated->sigma);
    precision.value = quantile(sigmas, 0.5);
  }

  std::vector<AccuracyFigure> figures{form, form_95, size,    spacing,  dimension,
                                      flat, flat_95, bending, precision};
  std::erase_if(figures, [](const AccuracyFigure& figure) { return std::isnan(figure.value); });

  return figures;
}

Artefacts read_artefacts(const fs::path& file) {
  Artefacts artefacts;
  for (const RigSetting& setting : read_rig(file)) {
    naming(fmt::format("{}: line {}: {}", file.string(), setting.line, setting.name),
           [&] { take(setting, file.parent_path(), artefacts); });
  }

  const std::string fault = fault_of(artefacts);
  throw_if(!fault.empty(), "{}: {}", file.string(), fault);

  return artefacts;
}

Verdict verdict_of(const Accuracy& accuracy) {
  double worst = 0, error = 0, noise = 0;  // the worst ratio; mm
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    const double bending = shape.bending.value_or(0);
    // Of the plane's deviations, bending is systematic and the rest is random.
    const double systematic =
        std::max({std::abs(shape.size.value_or(0)), std::abs(shape.spacing.value_or(0)), bending});
    const double random = std::sqrt(std::max(shape.rms * shape.rms - bending * bending, 1e-12));

    if (systematic / random < worst) continue;
    worst = systematic / random;
    error = systematic;
    noise = random;
  }

  // Random errors dominate up to a ratio of 1; above 3 a new calibration is worth it.
  const std::string figures =
      fmt::format("systematic errors up to {:.3f} mm, random errors {:.3f} mm", error, noise);
  if (accuracy.shapes.empty() || worst <= 1) return {"good", "Good: " + figures + "."};
  if (worst <= 3) return {"usable", "Usable: " + figures + "; a new calibration may be better."};
  return {"bad", "Do again: " + figures + "; calibrate geometry and gamma again."};
}

void write_accuracy_report(const fs::path& folder, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal) {
  make_folder(folder);

  Page page("Accuracy");
  page.verdict(verdict_of(accuracy));
  page.paragraph(
      "{}{}", subject,
      diagonal ? fmt::format("; diagonal of the measured volume {:.0f} mm", *diagonal) : "");

  page.table({"worst position", "mm", "per mille of the diagonal"});
  for (const AccuracyFigure& figure : accuracy_figures(accuracy)) {
    page.row({std::string(figure.what), cell(figure.value),
              diagonal ? cell(1000 * figure.value / *diagonal) : ""});
  }

  page.heading("Spheres and planes, mm");
  page.table({"", "99.7 %", "95 %", "RMS", "size", "spacing", "planarity"});
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    page.row({shape.scan, cell(shape.range), cell(shape.range_95), cell(shape.rms),
              cell(shape.size), cell(shape.spacing), cell(shape.bending)});
  }

  write_pictures(page, folder, accuracy);
  write_page(folder / "report.html", page);
}

}  // namespace slipstream
