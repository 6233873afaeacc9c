#include "slipstream/io/result_files.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/plot.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// `map`: what is written to the file, where that is a map that the cloud does not hold.
struct NamedFile {
  const char* name;
  std::string ResultFiles::*path;
  Image<float> Maps::*map = nullptr;
};

constexpr std::array<NamedFile, 10> all_files{
    {{"cloud", &ResultFiles::cloud},
     {"mesh", &ResultFiles::mesh},
     {"depth", &ResultFiles::depth},
     {"coordinate", &ResultFiles::coordinate, &Maps::coordinate},
     {"phase", &ResultFiles::phase, &Maps::wrapped_phase},
     {"modulation", &ResultFiles::modulation, &Maps::modulation},
     {"mean", &ResultFiles::mean, &Maps::mean},
     {"epipolar", &ResultFiles::epipolar, &Maps::epipolar_distance},
     {"motion", &ResultFiles::motion, &Maps::motion},
     {"preview", &ResultFiles::preview}}};

void replace_all(std::string& path, std::string_view placeholder, std::string_view name) {
  for (std::size_t at = path.find(placeholder); at != std::string::npos;
       at = path.find(placeholder, at + name.size())) {
    path.replace(at, placeholder.size(), name);
  }
}

/// One for all names of a file.
fs::path identity(const fs::path& path) {
  std::error_code unknown;
  fs::path whole = fs::weakly_canonical(fs::absolute(path, unknown), unknown);
  return unknown ? path : whole;
}

}  // namespace

std::vector<std::pair<const char*, std::string>> ResultFiles::named() const {
  std::vector<std::pair<const char*, std::string>> asked;
  for (const auto& [name, path, map] : all_files) {
    if (!(this->*path).empty()) asked.emplace_back(name, this->*path);
  }
  return asked;
}

std::vector<std::string> ResultFiles::written() const {
  std::vector<std::string> paths;
  for (const auto& [name, path] : named()) {
    paths.push_back(path);
    for (const auto& beside : files_beside(path)) paths.push_back(beside.string());
  }
  return paths;
}

bool ResultFiles::any_map() const {
  return std::any_of(all_files.begin(), all_files.end(), [this](const NamedFile& file) {
    return file.map != nullptr && !(this->*file.path).empty();
  });
}

std::string text_of(const ScanName& scan) {
  return scan.window ? fmt::format("{}, window {}", scan.path, *scan.window) : scan.path;
}

ResultFiles files_of_scan(const ResultFiles& files, const ScanName& scan) {
  const fs::path folder = scan.path;
  const fs::path whole = fs::absolute(folder / "").parent_path();
  const std::string name = (fs::is_directory(whole) ? whole.filename() : whole.stem()).string();
  ResultFiles filled = files;
  for (const NamedFile& file : all_files) {
    replace_all(filled.*file.path, "{name}", name);
    if (scan.window) replace_all(filled.*file.path, "{window}", fmt::format("{:06}", *scan.window));
  }
  return filled;
}

void require_writable(const ResultFiles& files, const std::vector<ScanName>& scans) {
  if (!files.cloud.empty()) require_cloud_ending(files.cloud);
  if (!files.mesh.empty()) require_mesh_ending(files.mesh);
  DistinctFiles distinct;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i == 0 || scans[i].path != scans[i - 1].path) distinct.add_input(scans[i].path);
  }
  for (const ScanName& scan : scans) {
    for (const auto& [name, path] : files_of_scan(files, scan).named()) distinct.add_output(path);
  }
}

void write_results(const ResultFiles& files, const Cloud& cloud, const Maps& maps,
                   const CloudExtras& extras) {
  if (!files.cloud.empty()) write_cloud(files.cloud, cloud, extras);
  if (!files.mesh.empty()) write_surface(files.mesh, surface_of(cloud));
  if (!files.depth.empty()) write_map(files.depth, cloud.z);
  for (const auto& [name, path, map] : all_files) {
    if (map != nullptr && !(files.*path).empty()) write_map(files.*path, maps.*map);
  }
  if (!files.preview.empty()) write_depth_preview(files.preview, cloud);
}

void DistinctFiles::add_input(const fs::path& path) {
  std::error_code unknown;
  if (!inputs_.insert(identity(path)).second || !fs::is_directory(path, unknown)) return;
  ScanFiles scan;
  try {
    const fs::path description = path / "scan.yaml";
    inputs_.insert(identity(description));
    if (fs::exists(description, unknown)) {
      scan = read_scan_files(description);
    } else {
      scan.frames = images_in_folder(path);
    }
  } catch (const std::exception&) {
    return;  // who reads it says why
  }
  for (const fs::path& frame : scan.frames) inputs_.insert(identity(frame));
  if (scan.scanner) add_scanner(*scan.scanner);
  if (scan.second_camera) add_input(*scan.second_camera);
}

void DistinctFiles::add_output(const fs::path& path) {
  if (path.empty()) return;
  const fs::path file = identity(path);
  if (inputs_.contains(file)) {
    throw Error(fmt::format("{}: is read, and would be written over; name another", path.string()));
  }
  if (!outputs_.insert(file).second) {
    throw Error(
        fmt::format("{}: two outputs would be written to it; give each its own name, which "
                    "{{name}} in it does with several scans",
                    path.string()));
  }
  for (const fs::path& beside : files_beside(path)) add_output(beside);
}

void DistinctFiles::add_scanner(const fs::path& path) {
  scanners_.insert(identity(path));
  add_input(path);
}

void DistinctFiles::add_scanner_output(const fs::path& path) {
  if (!scanners_.contains(identity(path))) add_output(path);
}

}  // namespace slipstream
