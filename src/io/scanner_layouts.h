#pragma once

#include <array>
#include <string_view>

#include "io/opencv_storage.h"

// The names that slipstream and other tools give to the entries of a calibration.
namespace slipstream {

/// The names of a lens's entries; "" if a layout lacks one. Without a height, the width's entry has
/// both; without a width, the height's has both, height first.
struct LensNames {
  std::string_view matrix, distortion, width, height;
};

/// The names of one tool.
struct ScannerLayout {
  LensNames camera, projector;
  std::string_view rotation, translation;  ///< "": the pose is in other entries
};

/// Begins the names of the second of two files that use the same names.
inline constexpr std::string_view of_projector = "the projector's ";

/// The layout with projection matrices; its sizes have slipstream's names.
inline constexpr std::array<std::string_view, 2> projection_entries{"camera_projection",
                                                                    "projector_projection"};

/// The residual maps of camera and projector, in all layouts: two rows, for x and y, of the centre,
/// the half size and the terms.
inline constexpr std::array<std::string_view, 2> residual_entries{"camera_residual",
                                                                  "projector_residual"};

/// The layouts of all known tools; slipstream's own, which is also written, comes first.
extern const std::array<ScannerLayout, 15> scanner_layouts;

/// Whether a layout's second device is a camera or, with `if_either`, only numbered as the second.
bool is_camera_pair(const ScannerLayout& layout, bool if_either);

bool has(const StoredEntries& entries, std::string_view name);

/// The layout that has most of its names in the file. Throws Error if none names a camera matrix.
const ScannerLayout& layout_of(const StoredEntries& entries);

/// Whether a layout gives this name to a part of the geometry.
bool names_geometry(std::string_view entry);

}  // namespace slipstream
