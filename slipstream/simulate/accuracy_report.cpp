#include "slipstream/simulate/accuracy_report.h"

#include "slipstream/io/file.h"
#include "slipstream/io/page.h"
#include "slipstream/io/preview.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string cell(std::optional<double> value) {
  return value ? fmt::format("{:.4f}", *value) : "";
}

void write_figures(Page& page, const Accuracy& accuracy, std::optional<double> diagonal) {
  page.table({"worst position", "mm", "per mille of the diagonal"});
  for (const AccuracyFigure& figure : accuracy_figures(accuracy)) {
    page.row({std::string(figure.what), cell(figure.value),
              diagonal ? cell(1000 * figure.value / *diagonal) : ""});
  }
}

void write_shapes(Page& page, const Accuracy& accuracy) {
  page.heading("Spheres and planes, mm");
  page.table({"", "99.7 %", "95 %", "RMS", "size", "spacing", "planarity"});
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    page.row({shape.scan, cell(shape.range), cell(shape.range_95), cell(shape.rms),
              cell(shape.size), cell(shape.spacing), cell(shape.bending)});
  }
}

/// Of the sphere and the plane of largest form error, and of the repeated scans.
void write_pictures(Page& page, const fs::path& folder, const Accuracy& accuracy) {
  const auto add = [&](const std::string& says, const char* file, const Image<double>& map) {
    write_map_preview(folder / file, map, "mm");
    page.picture(says, file);
  };
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

void write_accuracy_report(const fs::path& folder, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal) {
  make_folder(folder);
  Page page("Accuracy");
  page.paragraph(
      "{}{}", subject,
      diagonal ? fmt::format("; diagonal of the measured volume {:.0f} mm", *diagonal) : "");
  write_figures(page, accuracy, diagonal);
  write_shapes(page, accuracy);
  write_pictures(page, folder, accuracy);
  write_file(folder / "report.md", page.text());
}

}  // namespace slipstream
