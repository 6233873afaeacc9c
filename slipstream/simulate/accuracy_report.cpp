#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/file.h"
#include "slipstream/io/page.h"
#include "slipstream/io/plot.h"
#include "slipstream/io/rig_file.h"
#include "slipstream/simulate/accuracy.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

double length_from(const std::string& text) {
  constexpr double longest = 1e6;
  const auto length = number_in<double>(text);
  if (!length || !(*length > 0) || *length > longest) {
    throw Error(fmt::format("'{}' is no length, 0 to {:g} mm", text, longest));
  }
  return *length;
}

double one_length_from(const std::vector<std::string>& values) {
  if (values.size() != 1) throw Error("one length is wanted");
  return length_from(values.front());
}

void take(const RigSetting& setting, const fs::path& folder, Artefacts& artefacts) {
  const std::map<std::string, std::vector<std::string>*> scans{{"spheres", &artefacts.spheres},
                                                               {"planes", &artefacts.planes},
                                                               {"repeated", &artefacts.repeated}};
  if (const auto kind = scans.find(setting.name); kind != scans.end()) {
    for (const std::string& scan : setting.values) kind->second->push_back(folder / scan);
  } else if (setting.name == "diameters") {
    for (const std::string& text : setting.values) {
      artefacts.diameters.push_back(length_from(text));
    }
  } else if (setting.name == "distance") {
    artefacts.distance = one_length_from(setting.values);
  } else if (setting.name == "diagonal") {
    artefacts.diagonal = one_length_from(setting.values);
  } else {
    const std::vector<std::string> known{"diameters", "distance", "spheres",
                                         "planes",    "repeated", "diagonal"};
    throw Error(fmt::format("not known; it is one of: {}{}", fmt::join(known, ", "),
                            did_you_mean(setting.name, known)));
  }
}

/// What does not go together; empty where all does.
std::string fault_of(const Artefacts& artefacts) {
  const std::size_t spheres = artefacts.diameters.size();
  if (spheres > 2) return "diameters: one or two are wanted";
  if (artefacts.distance.has_value() != (spheres == 2)) {
    return "two diameters and the distance of their spheres go together";
  }
  if (artefacts.spheres.empty() != (spheres == 0)) {
    return "diameters and the scans of spheres go together";
  }
  if (artefacts.repeated.size() == 1) return "repeated: two scans or more are wanted";
  const bool none =
      artefacts.spheres.empty() && artefacts.planes.empty() && artefacts.repeated.empty();
  return none ? "no scans are named" : "";
}

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

Artefacts read_artefacts(const fs::path& file) {
  Artefacts artefacts;
  for (const RigSetting& setting : read_rig(file)) {
    try {
      take(setting, file.parent_path(), artefacts);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: line {}: {}: {}", file.string(), setting.line, setting.name,
                              error.what()));
    }
  }
  const std::string fault = fault_of(artefacts);
  if (!fault.empty()) throw Error(fmt::format("{}: {}", file.string(), fault));
  return artefacts;
}

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
