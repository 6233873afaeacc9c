#pragma once

#include <filesystem>
#include <string>

#include "slipstream/io/scan_folder.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// Reads the triangles of a PLY or OBJ file, all its parts as one mesh, in the file's units and
/// axes. Throws Error, naming the file, when it cannot be read or has no triangle.
Mesh read_mesh(const std::filesystem::path& path);

/// Writes a virtual scan, its scanner as a calibration would find it, and the truth into truth/:
/// depth.tiff, coordinate.tiff, reflectivity.tiff; a recording, without truth, where the path ends
/// in .slip. Returns what is said of the scan.
ScanFiles save_virtual_scan(const std::filesystem::path& path, const Sequence& sequence,
                            const VirtualWorld& world, const VirtualScan& taken);

/// Takes and writes scans of a sheet along x and y in each pose, into folders board01/x, board01/y,
/// board02/x and so on, each with noise of its own, and the world's scanner. Returns the names of
/// the poses; `saved` is called after each.
std::vector<std::string> save_board_scans(const std::filesystem::path& folder,
                                          const Sequence& sequence, const VirtualWorld& world,
                                          Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                                          const std::function<void()>& saved);

}  // namespace slipstream
