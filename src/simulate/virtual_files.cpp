#include "simulate/virtual_files.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace fs = std::filesystem;

Mesh read_mesh(const std::filesystem::path& path) {
  require_ending(path, "mesh format", {".ply", ".obj"});
  StoredPoints stored = read_points(path);

  Mesh mesh{.vertices = {}, .triangles = std::move(stored.triangles)};
  for (const auto& point : stored.points) mesh.vertices.emplace_back(point.x, point.y, point.z);
  throw_if(mesh.triangles.empty(), "{}: no triangles; expected a complete PLY or OBJ mesh",
           path.string());

  const std::string name = path.string();
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    throw_if(!vertex.allFinite(), "{}: a vertex is not finite", name);
  }

  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) {
      throw_if(corner < 0 || static_cast<std::size_t>(corner) >= mesh.vertices.size(),
               "{}: a triangle refers to vertex {} of {}", name, corner, mesh.vertices.size());
    }
  }

  return mesh;
}

ScanFiles save_virtual_scan(const fs::path& path, const Sequence& sequence,
                            const VirtualWorld& world, const VirtualScan& taken) {
  ScanFiles files = save_scan(
      path, taken.frames, sequence,
      {.scanner = as_calibrated(world), .in_colour = taken.in_colour, .white = taken.white});
  if (is_recording(path)) return files;

  const fs::path truth = path / "truth";
  make_folder(truth);
  write_map(truth / "depth.tiff", taken.depth);
  write_map(truth / "coordinate.tiff", taken.coordinate);
  write_map(truth / "reflectivity.tiff", taken.reflectivity);
  return files;
}

std::vector<std::string> save_board_scans(const fs::path& folder, const Sequence& sequence,
                                          const VirtualWorld& world, Body sheet,
                                          const std::vector<Eigen::Isometry3d>& poses,
                                          const std::function<void()>& saved) {
  const fs::path scanner_file = folder / "scanner.yaml";
  make_folder(folder);
  write_scanner(scanner_file, world.scanner);

  Photometry photometry = world.photometry;
  photometry.rays = 1;  // a printed sheet already has soft edges
  std::vector<std::string> names;

  for (const Eigen::Isometry3d& pose : poses) {
    sheet.pose = pose;
    names.push_back(fmt::format("board{:02}", names.size() + 1));

    for (const Axis axis : {Axis::x, Axis::y}) {
      const Sequence of_axis = along(sequence, axis);
      const FrameSet frames =
          take_scan(world.scanner, {sheet}, pattern_set(of_axis), photometry).frames;
      save_scan(folder / names.back() / name_of(axis), frames, of_axis,
                {.scanner_file = scanner_file});
      ++photometry.seed;
    }
    saved();
  }

  return names;
}

}  // namespace slipstream
