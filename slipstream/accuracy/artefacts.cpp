#include "slipstream/accuracy/artefacts.h"

#include <array>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/did_you_mean.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/rig_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::string_view, 6> known{"diameters", "distance", "spheres",
                                                "planes",    "repeated", "diagonal"};

double length_from(const std::string& text, const std::string& name) {
  constexpr double longest = 1e6;
  double length = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), length);
  if (failed != std::errc() || end != text.data() + text.size() ||
      !(length > 0 && length <= longest)) {
    throw Error(fmt::format("{}: '{}' is no length, 0 to {:g} mm", name, text, longest));
  }
  return length;
}

std::vector<double> lengths_from(const RigSetting& setting) {
  std::vector<double> lengths;
  for (const std::string& text : setting.values) {
    lengths.push_back(length_from(text, setting.name));
  }
  return lengths;
}

double one_length_from(const RigSetting& setting) {
  if (setting.values.size() != 1) throw Error(setting.name + ": one length is wanted");
  return lengths_from(setting).front();
}

void take(const RigSetting& setting, const fs::path& folder, Artefacts& artefacts) {
  std::vector<std::string> scans;
  for (const std::string& value : setting.values) scans.push_back((folder / value).string());
  if (setting.name == "diameters") {
    artefacts.diameters = lengths_from(setting);
  } else if (setting.name == "distance") {
    artefacts.distance = one_length_from(setting);
  } else if (setting.name == "diagonal") {
    artefacts.diagonal = one_length_from(setting);
  } else if (setting.name == "spheres") {
    artefacts.spheres = scans;
  } else if (setting.name == "planes") {
    artefacts.planes = scans;
  } else if (setting.name == "repeated") {
    artefacts.repeated = scans;
  } else {
    throw Error(fmt::format("there is no '{}' here; it is one of: {}{}", setting.name,
                            fmt::join(known, ", "), did_you_mean(setting.name, known)));
  }
}

/// What does not go together.
void require_whole(const Artefacts& artefacts) {
  const std::size_t spheres = artefacts.diameters.size();
  if (spheres > 2) throw Error("diameters: one or two are wanted");
  if (artefacts.distance.has_value() != (spheres == 2)) {
    throw Error("two diameters and the distance of their spheres go together");
  }
  if (artefacts.spheres.empty() != (spheres == 0)) {
    throw Error("diameters and the scans of spheres go together");
  }
  if (artefacts.repeated.size() == 1) throw Error("repeated: two scans or more are wanted");
  if (artefacts.spheres.empty() && artefacts.planes.empty() && artefacts.repeated.empty()) {
    throw Error("no scans are named");
  }
}

}  // namespace

Artefacts read_artefacts(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = read_file(file);
  return artefacts_from({bytes.begin(), bytes.end()}, file);
}

Artefacts artefacts_from(const std::string& text, const fs::path& file) {
  Artefacts artefacts;
  for (const RigSetting& setting : rig_from(text, file.string())) {
    try {
      take(setting, file.parent_path(), artefacts);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: line {}: {}", file.string(), setting.line, error.what()));
    }
  }
  try {
    require_whole(artefacts);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", file.string(), error.what()));
  }
  return artefacts;
}

}  // namespace slipstream
