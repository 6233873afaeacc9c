#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/scan_folder.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// Reads the triangles of a PLY or OBJ file, all its parts as one mesh, in the file's units and
/// axes. Throws Error with the file's name if it cannot be read or has no triangles.
Mesh read_mesh(const std::filesystem::path& path);

/// Writes a virtual scan with its calibrated scanner, and the ground truth into truth/: depth.tiff,
/// coordinate.tiff, reflectivity.tiff. Writes a recording without ground truth if the path ends in
/// .slip. Returns the description of the scan.
ScanFiles save_virtual_scan(const std::filesystem::path& path, const Sequence& sequence,
                            const VirtualWorld& world, const VirtualScan& taken);

/// Simulates and writes scans of a sheet along x and y in each pose, into folders board01/x,
/// board01/y, board02/x and so on, each with its own noise, and the world's scanner. Calls `saved`
/// after each pose. Returns the names of the poses.
std::vector<std::string> save_board_scans(const std::filesystem::path& folder,
                                          const Sequence& sequence, const VirtualWorld& world,
                                          Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                                          const std::function<void()>& saved);

}  // namespace slipstream
