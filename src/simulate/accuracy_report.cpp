#include "simulate/accuracy_report.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string cell(std::optional<double> value) {
  return value ? fmt::format("{:.4f}", *value) : "";
}

std::string cell(const std::optional<Estimate>& estimate) {
  return estimate ? cell(estimate->value) : "";
}

/// "40.002 mm, expanded uncertainty 0.0006 mm (k = 2)"
std::string certified(const std::vector<double>& lengths, std::optional<double> uncertainty) {
  const std::string text = fmt::format("{:.6g} mm", fmt::join(lengths, " and "));
  return uncertainty ? fmt::format("{}, expanded uncertainty {:g} mm (k = 2)", text, *uncertainty)
                     : text + ", uncertainty not stated";
}

void add_artefacts(Facts& facts, const Artefacts& artefacts) {
  for (const std::string& note : artefacts.notes) facts.emplace_back("", note);

  if (!artefacts.diameters.empty()) {
    facts.emplace_back("certified diameters",
                       certified(artefacts.diameters, artefacts.diameter_uncertainty));
  }
  if (artefacts.distance) {
    facts.emplace_back("certified distance",
                       certified({*artefacts.distance}, artefacts.distance_uncertainty));
  }

  if (artefacts.diagonal) {
    facts.emplace_back("diagonal of the measured volume",
                       fmt::format("{:.0f} mm", *artefacts.diagonal));
  }
  facts.emplace_back("temperature of the room",
                     artefacts.temperature
                         ? fmt::format("{:g} degrees Celsius", *artefacts.temperature)
                         : "not stated");
}

void write_figures(Page& page, const AccuracyReport& report) {
  page.heading("Figures of the worst position");
  page.table({"figure", "named in", "measured, mm", "standard uncertainty, mm", "limit, mm",
              "result", "per mille of the diagonal"});

  for (const AccuracyFigure& figure : report.figures) {
    const std::optional<double> diagonal = report.artefacts.diagonal;
    const std::string result = figure.fails() ? "fail" : "pass";

    page.row({std::string(figure.what), std::string(figure.standard), cell(figure.measured.value),
              cell(figure.measured.uncertainty),
              figure.limit ? fmt::format("{:g}", *figure.limit) : "", figure.limit ? result : "",
              diagonal ? cell(1000 * figure.measured.value / *diagonal) : ""});
  }

  page.paragraph(
      "The uncertainty counts the scatter of the points, taken as independent, and the certified "
      "length. It does not count temperature, nor the calibration of the scanner.");
}

void write_positions(Page& page, const Accuracy& accuracy) {
  page.heading("Positions");
  page.table({"scan", "shape", "points", "centre X, Y, Z, mm", "form 99.7 %, mm", "form 95 %, mm",
              "RMS, mm", "size error, mm", "spacing error, mm", "planarity, mm"});

  for (const ShapeAccuracy& shape : accuracy.shapes) {
    const Eigen::Vector3d centre = shape.extent.center();
    page.row({shape.scan, shape.size ? "sphere" : "plane", std::to_string(shape.points),
              fmt::format("{}, {}, {}", std::lround(centre.x()), std::lround(centre.y()),
                          std::lround(centre.z())),
              cell(shape.range), cell(shape.range_95), cell(shape.rms), cell(shape.size),
              cell(shape.spacing), cell(shape.bending)});
  }
}

/// Rectangles around the points of each sphere and plane, seen along one axis.
LinePlot plot_of_positions(const Accuracy& accuracy, const std::string& title, int across, int up,
                           double sign) {
  LinePlot plot{.title = title,
                .x_label = fmt::format("{}, mm", "XYZ"[across]),
                .y_label = fmt::format("{}{}, mm", sign < 0 ? "-" : "", "XYZ"[up]),
                .lines = {{.label = "spheres"}, {.label = "planes"}}};

  for (const ShapeAccuracy& shape : accuracy.shapes) {
    PlotLine& line = plot.lines[shape.size ? 0 : 1];
    const Eigen::Vector3d low = shape.extent.min(), high = shape.extent.max();

    line.add(low[across], sign * low[up]);
    line.add(high[across], sign * low[up]);
    line.add(high[across], sign * high[up]);
    line.add(low[across], sign * high[up]);
    line.add(low[across], sign * low[up]);
    line.add(nan, nan);
  }

  std::erase_if(plot.lines, [](const PlotLine& line) { return line.x.empty(); });
  return plot;
}

/// Pictures of the positions, of the sphere and the plane with the largest form error, and of the
/// repeated scans.
void write_pictures(Page& page, const fs::path& folder, const Accuracy& accuracy) {
  const auto add = [&](const std::string& says, const char* file, const Image<double>& map) {
    write_map_preview(folder / file, map, "mm");
    page.picture(says, file);
  };

  // 1. Where the shapes stood, in the camera's frame, whose Y points down.
  if (!accuracy.shapes.empty()) {
    write_plot(folder / "front.png", plot_of_positions(accuracy, "seen by the camera", 0, 1, -1));
    write_plot(folder / "top.png", plot_of_positions(accuracy, "seen from above", 0, 2, 1));
    page.picture("where the points of each position lie, seen by the camera", "front.png");
    page.picture("the same from above; the camera is at Z = 0", "top.png");
  }

  // 2. The worst sphere and the worst plane, by form error. Only spheres have a size.
  const ShapeAccuracy *sphere = nullptr, *plane = nullptr;
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    const ShapeAccuracy*& worst = shape.size ? sphere : plane;
    if (worst == nullptr || shape.range.value > worst->range.value) worst = &shape;
  }

  if (sphere != nullptr) add("deviations: " + sphere->scan, "sphere.png", sphere->deviation);
  if (plane != nullptr) add("deviations: " + plane->scan, "plane.png", plane->deviation);

  // 3. The repeated scans.
  if (accuracy.repeated) {
    add(fmt::format("sigma of Z over {} scans", accuracy.repeated->scans), "repeated.png",
        accuracy.repeated->sigma);
  }
}

}  // namespace

void write_accuracy_report(const fs::path& folder, const AccuracyReport& report) {
  make_folder(folder);

  Page page("Accuracy of a 3-D scanner");
  page.verdict(report.verdict);

  Facts facts = report.facts;
  add_artefacts(facts, report.artefacts);
  page.facts(facts);

  write_figures(page, report);
  if (!report.budget.empty()) {
    page.heading("Error of depth of a scan, by source");
    page.facts(report.budget);
  }
  write_positions(page, report.accuracy);
  write_pictures(page, folder, report.accuracy);

  page.signature();
  write_page(folder / "report.html", page);
}

}  // namespace slipstream
