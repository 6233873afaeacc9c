#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Reads a scanner from an OpenCV FileStorage file (YAML or XML) in one of five layouts, told by
/// the names in it:
///   camera_matrix camera_distortion camera_width camera_height projector_matrix
///     projector_distortion projector_width projector_height rotation translation (slipstream's);
///   Kc kc Kp kp Rp Tp frameWidth frameHeight screenResX screenResY;
///   cam_K cam_kc proj_K proj_kc R T, which says no sizes: they come out empty;
///   M1 D1 S M4 D4 Rlp Tlp, which says the camera's size alone: S, its width and height;
///   camera_projection projector_projection and sizes as slipstream's: the 3x4 matrices from one
///     world, mm, to the pixels of either, up to scale (see scanner_of in projection_matrices.h).
/// Distortion may be missing (none) and sizes too. Rotation and translation take the camera's frame
/// to the projector's, mm. What is known of light and sensor, see photometric_file.h, and the line
/// of text `measured` are read too. A recording serves as well, with what it holds. Throws Error,
/// naming the file and the entry, for anything missing, of another shape, or not a number.
Scanner read_scanner(const std::filesystem::path& path);

/// The same of such a file's text; `name` is what a message calls it.
Scanner scanner_from(const std::string& text, const std::string& name);

/// The text of a YAML file of slipstream's layout.
std::string text_of(const Scanner& scanner);

/// Writes slipstream's layout, YAML or (ending .xml) XML, with all that the scanner holds.
void write_scanner(const std::filesystem::path& path, const Scanner& scanner);

/// The same, but where `path` is a scanner file already, its entries that say nothing of the
/// geometry, such as gamma, are kept; `measured` is not. Returns the names of those kept.
std::vector<std::string> replace_geometry(const std::filesystem::path& path,
                                          const Scanner& scanner);

}  // namespace slipstream
