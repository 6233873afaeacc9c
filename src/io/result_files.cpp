#include "io/result_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fnmatch.h>
#include <glob.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "io/scan_folder.h"
#include "io/scan_pictures.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// `map`: the map to write, if it is not part of the cloud.
struct NamedFile {
  const char* name;
  std::string ResultFiles::*path;
  Image<float> Maps::*map = nullptr;
};

constexpr std::array<NamedFile, 11> all_files{
    {{"cloud", &ResultFiles::cloud},
     {"mesh", &ResultFiles::mesh},
     {"depth", &ResultFiles::depth},
     {"coordinate", &ResultFiles::coordinate, &Maps::coordinate},
     {"phase", &ResultFiles::phase, &Maps::wrapped_phase},
     {"modulation", &ResultFiles::modulation, &Maps::modulation},
     {"mean", &ResultFiles::mean, &Maps::mean},
     {"epipolar", &ResultFiles::epipolar, &Maps::epipolar_distance},
     {"motion", &ResultFiles::motion, &Maps::motion},
     {"reflection", &ResultFiles::reflection, &Maps::reflection},
     {"preview", &ResultFiles::preview}}};

void replace_all(std::string& path, std::string_view placeholder, std::string_view name) {
  for (std::size_t at = path.find(placeholder); at != std::string::npos;
       at = path.find(placeholder, at + name.size())) {
    path.replace(at, placeholder.size(), name);
  }
}

/// Canonical path, the same for all names of a file.
fs::path identity(const fs::path& path) {
  std::error_code unknown;
  fs::path whole = fs::weakly_canonical(fs::absolute(path, unknown), unknown);
  return unknown ? path : whole;
}

/// The output's path as a shell pattern: its own special characters are escaped, its placeholders
/// become wildcards.
std::string pattern_of(const fs::path& output) {
  std::string pattern;
  for (const char c : output.string()) {
    if (std::strchr("*?[\\", c) != nullptr) pattern += '\\';
    pattern += c;
  }

  replace_all(pattern, "{name}", "*");
  replace_all(pattern, "{window}", "[0-9][0-9][0-9][0-9][0-9][0-9]");
  return pattern;
}

/// Whether the output, its placeholders filled, may be that file.
bool may_become(const fs::path& output, const fs::path& file) {
  return output.extension() == file.extension() &&
         ::fnmatch(pattern_of(output).c_str(), file.c_str(), FNM_PATHNAME) == 0;
}

/// How files begin that the program writes.
constexpr std::pair<std::string_view, std::string_view> beginnings[] = {
    {".slip", "SLIPFRMS"},     {".mcap", "\x89MCAP0"},  {".ply", "ply\n"},
    {".pcd", "# .PCD"},        {".stl", "slipstream,"}, {".obj", "# slipstream,"},
    {".mtl", "newmtl camera"}, {".glb", "glTF"},        {".png", "\x89PNG"},
    {".tiff", "II*"},          {".tif", "II*"},         {".bmp", "BM"},
    {".npy", "\x93NUMPY"},     {".yaml", "%YAML:1.0"},  {".html", "<!doctype html>"},
    {".csv", "swap,pattern,"}, {".jsonl", "{\""}};

/// Parses a whole number; returns `otherwise` for an empty text.
std::optional<std::uint64_t> number_from(std::string_view text, std::uint64_t otherwise) {
  return text.empty() ? otherwise : number_in<std::uint64_t>(text);
}

ListedScans listed_from(std::string_view line) {
  ListedScans scans{.path = std::string(take_until(line, '\t'))};
  const std::string_view windows = take_until(line, '\t');
  if (!windows.empty()) scans.windows = window_range_from(windows);

  const auto cost = number_from(take_until(line, '\t'), 0),
             shard = number_from(take_until(line, '\t'), 0);

  constexpr std::uint64_t exact = std::uint64_t{1} << 53;  // in a double
  throw_if(scans.path.empty() || !cost || *cost > exact || !shard || !line.empty(),
           "expected PATH, A:B, COST and SHARD separated by tabs");

  scans.cost = *cost;
  scans.shard = *shard;
  return scans;
}

/// Modulation, and the phase of the measured pixels.
void write_preview_of_maps(const fs::path& path, const Image<Validity>& validity,
                           const Maps& maps) {
  // Codes have no phase.
  const Image<double> modulation = converted<double>(maps.modulation);
  if (maps.wrapped_phase.empty()) return write_map_preview(path, modulation, "modulation");

  Image<double> phase = converted<double>(maps.wrapped_phase);
  for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
    if (validity.begin()[i] != Validity::valid) phase.begin()[i] = nan;
  }

  write_modulation_and_phase(path, modulation, phase);
}

}  // namespace

std::vector<std::pair<const char*, std::string>> ResultFiles::named() const {
  std::vector<std::pair<const char*, std::string>> files;
  for (const auto& [name, path, map] : all_files) {
    if (!(this->*path).empty()) files.emplace_back(name, this->*path);
  }
  return files;
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
  return std::ranges::any_of(all_files, [this](const NamedFile& file) {
    return file.map != nullptr && !(this->*file.path).empty();
  });
}

bool ResultFiles::only_maps() const {
  return any_map() && !need_points() && preview.empty();
}

bool ResultFiles::need_points() const {
  return !(cloud.empty() && mesh.empty() && depth.empty() && epipolar.empty() &&
           reflection.empty());
}

std::string text_of(const ScanName& scan) {
  return scan.window ? fmt::format("{}, window {}", scan.path, *scan.window) : scan.path;
}

ResultFiles files_of_scan(const ResultFiles& files, const ScanName& scan) {
  // The folder's name, also of "." and "..", or the recording's without its ending.
  const fs::path folder = scan.path;
  const fs::path whole = fs::absolute(folder / "").lexically_normal().parent_path();
  const std::string name = (fs::is_directory(folder) ? whole.filename() : whole.stem()).string();
  const bool leads_elsewhere = name.empty() || name == "." || name == "..";

  ResultFiles filled = files;
  for (const NamedFile& file : all_files) {
    std::string& path = filled.*file.path;
    throw_if(leads_elsewhere && path.find("{name}") != std::string::npos,
             "{}: {{name}} cannot stand for '{}'; name the scan otherwise", scan.path, name);

    // The window first: a name may hold the text {window}.
    if (scan.window) replace_all(path, "{window}", fmt::format("{:06}", *scan.window));
    replace_all(path, "{name}", name);
  }
  return filled;
}

std::vector<fs::path> files_replaced_by(const fs::path& output) {
  std::vector<fs::path> outputs = files_beside(output), found;
  outputs.push_back(output);

  for (const fs::path& path : outputs) {
    glob_t matches{};
    if (::glob(pattern_of(path).c_str(), GLOB_PERIOD, nullptr, &matches) == 0) {
      found.insert(found.end(), matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
    }
    ::globfree(&matches);
  }
  return found;
}

bool has_format_of_ending(const fs::path& file) {
  const auto* const format =
      std::ranges::find(beginnings, lower_case_extension(file),
                        &std::pair<std::string_view, std::string_view>::first);
  if (format == std::end(beginnings)) return false;

  const InputFile input(file, no_limit);
  std::vector<std::uint8_t> begin(format->second.size());
  return input.size() == 0 ||
         (input.read(0, {begin}) && std::ranges::equal(begin, bytes_of(format->second)));
}

void require_writable(const ResultFiles& files, const std::vector<ScanName>& scans) {
  if (!files.cloud.empty()) require_cloud_ending(files.cloud);
  if (!files.mesh.empty()) require_mesh_ending(files.mesh);

  // Windows of one scan follow each other; their path is one input.
  DistinctFiles distinct;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i == 0 || scans[i].path != scans[i - 1].path) distinct.add_input(scans[i].path);
  }

  for (const auto& [name, path] : files.named()) {
    throw_if(scans.size() > 1 && path.find('{') == path.npos,
             "{}: {} scans would be written to it, {} and so on; put {{name}} in its name, or if "
             "these are pictures of one scan, give their folder",
             path, scans.size(), text_of(scans.front()));
  }

  for (const ScanName& scan : scans) {
    for (const auto& [name, path] : files_of_scan(files, scan).named()) distinct.add_output(path);
  }
}

void write_results(const ResultFiles& files, const Cloud& cloud, const Maps& maps,
                   const CloudExtras& extras) {
  if (!files.cloud.empty()) write_cloud(files.cloud, cloud, extras);
  if (!files.mesh.empty()) {
    Surface surface = surface_of(cloud);
    if (extras.frame) move_to_frame(surface, *extras.frame);
    write_surface(files.mesh, surface);
  }
  if (!files.depth.empty()) write_map(files.depth, cloud.z);

  for (const auto& [name, path, map] : all_files) {
    if (map != nullptr && !(files.*path).empty()) write_map(files.*path, maps.*map);
  }

  if (files.preview.empty()) return;
  if (cloud.z.empty()) {
    write_preview_of_maps(files.preview, cloud.validity, maps);
  } else {
    write_depth_preview(files.preview, cloud);
  }
}

void DistinctFiles::add_input(const fs::path& path, int levels) {
  std::error_code unknown;
  if (!inputs_.insert(identity(path)).second || !fs::is_directory(path, unknown)) return;

  ScanFiles scan;
  try {
    const fs::path description = path / "scan.yaml";
    inputs_.insert(identity(description));
    picture_folders_.insert(identity(path / "truth"));

    if (fs::exists(description, unknown)) {
      scan = read_scan_files(description);
    } else {
      scan.frames = images_in_folder(path);
      picture_folders_.insert(identity(path));
    }
  } catch (const std::exception&) {  // a folder of scans, or reading it will report the reason
    for (const fs::directory_entry& entry : fs::directory_iterator(path, unknown)) {
      const bool scans = entry.is_directory(unknown) ? is_scan_folder(entry.path())
                                                     : entry.path().extension() == ".slip";
      if (levels > 0 && scans) add_input(entry.path(), levels - 1);
    }
    return;
  }

  // Every file that the scan reads is an input.
  for (const fs::path& frame : scan.frames) inputs_.insert(identity(file_of_page(frame)));
  if (scan.white) inputs_.insert(identity(*scan.white));
  if (scan.colour_scanner) {
    for (const fs::path& file : scanner_files(*scan.colour_scanner)) add_input(file);
  }
  for (const fs::path& picture : scan.colour) inputs_.insert(identity(picture));
  if (scan.scanner) add_scanner(*scan.scanner);
  for (const fs::path& camera : scan.further_cameras) add_input(camera);
}

void DistinctFiles::add_output(const fs::path& path) {
  if (path.empty()) return;

  const fs::path file = identity(path);
  const bool fills = file.string().find('{') != std::string::npos;
  const auto fills_to = [&](const fs::path& input) { return may_become(file, input); };

  throw_if(inputs_.contains(file) || (fills && std::ranges::any_of(inputs_, fills_to)),
           "{}: is an input and would be overwritten; use another name", path.string());
  throw_if(is_image_file(file) && picture_folders_.contains(file.parent_path()),
           "{}: is an input, like every picture in its folder; write to another folder",
           path.string());

  throw_if(!outputs_.insert(file).second,
           "{}: two outputs would be written to it; use different names", path.string());

  for (const fs::path& beside : files_beside(path)) add_output(beside);
}

void DistinctFiles::add_output_folder(const fs::path& path) {
  const fs::path folder = identity(path);
  const auto clashes = [&](const fs::path& input) {
    return input.parent_path() == folder &&
           (is_image_file(input) || input.filename() == "scanner.yaml");
  };

  throw_if(inputs_.contains(folder) || std::ranges::any_of(inputs_, clashes),
           "{}: holds inputs that would be overwritten; use another folder", path.string());
}

void DistinctFiles::add_scanner(const fs::path& path) {
  const std::vector<fs::path> files = scanner_files(path);
  if (files.size() == 1) scanners_.insert(identity(path));

  for (const fs::path& file : files) add_input(file);
}

void DistinctFiles::add_scanner_output(const fs::path& path) {
  if (!scanners_.contains(identity(path))) add_output(path);
}

WindowRange window_range_from(std::string_view text) {
  std::string_view rest = text;
  const auto first = number_from(take_until(rest, ':'), 0);

  // A number without a colon is one window.
  const bool is_one = text.find(':') == std::string_view::npos;
  const auto end = is_one && first ? *first + 1 : number_from(rest, WindowRange::last);

  throw_if(text.empty() || !first || !end || *end <= *first,
           "'{}': expected a range of windows A:B, e.g. 0:100, 100: or :", text);

  return {*first, *end};
}

std::vector<ListedScans> scan_list_from(std::string_view text, const std::string& name) {
  std::vector<ListedScans> scans;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_until(text, '\n');
    if (line.empty()) continue;

    naming(fmt::format("{}: line {}", name, number), [&] { scans.push_back(listed_from(line)); });
  }
  return scans;
}

std::string text_of(const std::vector<ListedScans>& scans) {
  std::string text;
  for (const auto& [path, windows, cost, shard] : scans) {
    throw_if(path.find_first_of("\t\n") != std::string::npos,
             "{}: a name in a list must not contain a tab or a line break", path);

    std::string range;
    if (windows) range = fmt::format("{}:", windows->first);
    if (windows && windows->end != WindowRange::last) range += std::to_string(windows->end);

    text += fmt::format("{}\t{}\t{}\t{}\n", path, range, cost, shard);
  }
  return text;
}

std::uint64_t scan_count(const ListedScans& scans, std::uint64_t every) {
  if (!scans.windows) return 1;

  // Windows first, first + every and so on: rounded up.
  return (scans.windows->end - scans.windows->first - 1) / every + 1;
}

std::vector<ScanName> scan_names(const std::vector<ListedScans>& scans, std::uint64_t every) {
  std::vector<ScanName> names;
  for (const ListedScans& listed : scans) {
    const std::uint64_t count = scan_count(listed, every);
    throw_if(count > most_scans - names.size(), "{}: more than {} scans; split the run",
             listed.path, most_scans);

    if (!listed.windows) names.push_back({listed.path});
    for (std::uint64_t i = 0; listed.windows && i < count; ++i) {
      names.push_back({listed.path, listed.windows->first + i * every});
    }
  }

  return names;
}

std::vector<ListedScans> cut_into_shards(const std::vector<ListedScans>& scans, std::uint64_t every,
                                         std::uint64_t shards) {
  // `before`: the cost of all scans before the current one.
  double all = 0, before = 0;
  for (const ListedScans& listed : scans) all += static_cast<double>(listed.cost);

  std::vector<ListedScans> pieces;
  for (const ListedScans& listed : scans) {
    const std::uint64_t count = scan_count(listed, every);
    const double cost = static_cast<double>(listed.cost) / static_cast<double>(count);

    for (std::uint64_t i = 0; i < count; ++i, before += cost) {
      // A scan belongs to the shard that contains its middle.
      const double place = (before + cost / 2) / all * static_cast<double>(shards);
      const std::uint64_t shard = std::min(static_cast<std::uint64_t>(place) + 1, shards);

      // A list's entry is cut where its shard changes.
      if (i == 0 || shard != pieces.back().shard) {
        pieces.push_back({.path = listed.path, .windows = listed.windows, .shard = shard});
        if (listed.windows) pieces.back().windows->first += i * every;
      }

      pieces.back().cost += static_cast<std::uint64_t>(cost);
      if (!listed.windows) continue;
      pieces.back().windows->end =
          std::min(listed.windows->end, listed.windows->first + (i + 1) * every);
    }
  }

  return pieces;
}

}  // namespace slipstream
