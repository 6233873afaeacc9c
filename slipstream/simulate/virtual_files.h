#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/io/scan_folder.h"
#include "slipstream/simulate/mesh.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// Reads the triangles of a PLY or OBJ file, all its parts as one mesh, in the file's units and
/// axes. Throws Error, naming the file, when it cannot be read or has no triangle.
Mesh read_mesh(const std::filesystem::path& path);

/// Writes what the virtual scanner took, its scanner as a calibration would find it, and the truth
/// into truth/: depth.tiff, coordinate.tiff, reflectivity.tiff; where the path ends in .slip a
/// recording, which has no place for the truth. Returns what is said of the scan.
ScanFiles save_virtual_scan(const std::filesystem::path& path, const Sequence& sequence,
                            const VirtualWorld& world, const VirtualScan& taken);

/// Takes and writes scans of a sheet along x and along y in each pose, into folders board01/x,
/// board01/y, board02/x and so on, and the world's scanner beside them. Each scan has noise of its
/// own. Returns the names of the poses; `saved` is called after each.
std::vector<std::string> save_board_scans(const std::filesystem::path& folder,
                                          const Sequence& sequence, const VirtualWorld& world,
                                          Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                                          const std::function<void()>& saved);

}  // namespace slipstream
