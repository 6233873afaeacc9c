#include "simulate/artefacts.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/rig_file.h"
#include "slipstream/error.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

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

double temperature_from(const std::vector<std::string>& values) {
  const auto temperature = values.size() == 1 ? number_in<double>(values.front()) : std::nullopt;
  if (!temperature || !(std::abs(*temperature) <= 100)) {
    throw Error("expected a temperature, -100 to 100 degrees Celsius");
  }
  return *temperature;
}

void take(const RigSetting& setting, const fs::path& folder, Artefacts& artefacts) {
  // 1. Scans, by their names in the file.
  const std::map<std::string, std::vector<std::string>*> scans{{"spheres", &artefacts.spheres},
                                                               {"planes", &artefacts.planes},
                                                               {"repeated", &artefacts.repeated}};
  if (const auto kind = scans.find(setting.name); kind != scans.end()) {
    for (const std::string& scan : setting.values) kind->second->push_back(folder / scan);
    return;
  }

  // 2. Single lengths.
  const std::map<std::string, std::optional<double>*> lengths{
      {"distance", &artefacts.distance},
      {"diameter-uncertainty", &artefacts.diameter_uncertainty},
      {"distance-uncertainty", &artefacts.distance_uncertainty},
      {"diagonal", &artefacts.diagonal}};
  if (const auto length = lengths.find(setting.name); length != lengths.end()) {
    *length->second = one_length_from(setting.values);
    return;
  }

  // 3. All others.
  if (setting.name == "diameters") {
    for (const std::string& text : setting.values) artefacts.diameters.push_back(length_from(text));
  } else if (setting.name == "temperature") {
    artefacts.temperature = temperature_from(setting.values);
  } else if (setting.name == "notes") {
    artefacts.notes = setting.values;
  } else {
    const std::vector<std::string> known{"diameters",
                                         "distance",
                                         "diameter-uncertainty",
                                         "distance-uncertainty",
                                         "spheres",
                                         "planes",
                                         "repeated",
                                         "diagonal",
                                         "temperature",
                                         "notes"};
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

}  // namespace

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

}  // namespace slipstream
