#include "slipstream/io/result_files.h"

#include <array>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/io/distinct_files.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/preview.h"
#include "slipstream/io/surface_file.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<const char*, std::string ResultFiles::*>, 10> all_files{
    {{"cloud", &ResultFiles::cloud},
     {"mesh", &ResultFiles::mesh},
     {"depth", &ResultFiles::depth},
     {"coordinate", &ResultFiles::coordinate},
     {"phase", &ResultFiles::phase},
     {"modulation", &ResultFiles::modulation},
     {"mean", &ResultFiles::mean},
     {"epipolar", &ResultFiles::epipolar},
     {"motion", &ResultFiles::motion},
     {"preview", &ResultFiles::preview}}};

void replace_all(std::string& path, std::string_view placeholder, std::string_view name) {
  for (std::size_t at = path.find(placeholder); at != std::string::npos;
       at = path.find(placeholder, at + name.size())) {
    path.replace(at, placeholder.size(), name);
  }
}

void write_map_if_asked(const std::string& path, const Image<float>& map) {
  if (!path.empty()) write_map(path, map);
}

}  // namespace

std::vector<std::pair<const char*, std::string>> ResultFiles::named() const {
  std::vector<std::pair<const char*, std::string>> asked;
  for (const auto& [name, path] : all_files) {
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
  return !(coordinate.empty() && phase.empty() && modulation.empty() && mean.empty() &&
           epipolar.empty() && motion.empty());
}

std::string text_of(const ScanName& scan) {
  return scan.window ? fmt::format("{}, window {}", scan.path, *scan.window) : scan.path;
}

ResultFiles files_of_scan(const ResultFiles& files, const ScanName& scan) {
  const std::filesystem::path folder = scan.path;
  const std::filesystem::path whole = std::filesystem::absolute(folder / "").parent_path();
  const std::string name =
      (std::filesystem::is_directory(whole) ? whole.filename() : whole.stem()).string();
  ResultFiles filled = files;
  for (const auto& [kind, member] : all_files) {
    replace_all(filled.*member, "{name}", name);
    if (scan.window) replace_all(filled.*member, "{window}", fmt::format("{:06}", *scan.window));
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
  write_map_if_asked(files.depth, cloud.z);
  write_map_if_asked(files.coordinate, maps.coordinate);
  write_map_if_asked(files.phase, maps.wrapped_phase);
  write_map_if_asked(files.modulation, maps.modulation);
  write_map_if_asked(files.mean, maps.mean);
  write_map_if_asked(files.epipolar, maps.epipolar_distance);
  write_map_if_asked(files.motion, maps.motion);
  if (!files.preview.empty()) write_depth_preview(files.preview, cloud);
}

}  // namespace slipstream
