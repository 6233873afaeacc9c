#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/scanner.h"

namespace slipstream {

/// The files of a scanner: one, or those of camera and projector, separated by a comma:
/// "camera.xml,projector.xml".
std::vector<std::filesystem::path> scanner_files(const std::filesystem::path& path);

/// The same path with its relative names in `folder`.
std::filesystem::path scanner_in(const std::filesystem::path& folder,
                                 const std::filesystem::path& path);

/// Reads a scanner from an OpenCV FileStorage file (YAML or XML), or from two, see scanner_files.
/// Its layout is identified by its names: slipstream's,
///   camera_matrix camera_distortion camera_width camera_height projector_matrix
///     projector_distortion projector_width projector_height rotation translation;
/// another tool's, see the tables in docs/reference/files.md; or
///   camera_projection projector_projection and sizes as in slipstream's layout: 3x4 matrices from
///     a common world frame, mm, to the pixels of either, up to scale (see scanner_of in
///     scanner.h).
/// Distortion and sizes are optional. Rotation and translation map the camera's frame to the
/// projector's, mm. Also reads the calibration of light and sensor, see below, and the text
/// `measured`. Accepts a recording with a scanner. Throws Error with file and entry for a missing
/// entry, a wrong shape or a value that is not a number.
Scanner read_scanner(const std::filesystem::path& path);

/// The same for a file's text; `name`: the file's name in messages.
Scanner scanner_from(const std::string& text, const std::string& name);

/// Reads the calibration of two cameras without a projector, as read_scanner: slipstream's layout
/// with second_camera_matrix, second_camera_distortion, second_camera_width and
/// second_camera_height in place of the projector's, or another tool's that only numbers its
/// devices. The second camera is the result's `projector`.
Scanner read_camera_pair(const std::filesystem::path& path);

/// Whether the file calibrates two cameras by slipstream's names or, with `if_either`, may do so by
/// another tool's.
bool is_camera_pair(const std::filesystem::path& path, bool if_either);

/// The text of a YAML file in slipstream's layout.
std::string text_of(const Scanner& scanner);

/// Writes the complete scanner in slipstream's layout, as YAML or, for the ending .xml, XML.
void write_scanner(const std::filesystem::path& path, const Scanner& scanner);

/// The same, but keeps the entries of an existing scanner file that do not concern the geometry,
/// such as gamma; replaces `measured`. Returns the names of the entries kept.
std::vector<std::string> replace_geometry(const std::filesystem::path& path,
                                          const Scanner& scanner);

// Entries of a scanner file for light and sensor, all optional:
//   ambient_light, noise_variance          numbers
//   noise_gain                             a number, default 0
//   gamma, gamma_standard_error            of a power law, or the one nearest to a curve
//   response_values, response_light        a measured curve, two rows of numbers
//   colour_mixture                         3x4, see ColourMixture

/// Reads these entries; the file may have no others. Throws Error with file and entry for a wrong
/// shape or a value out of range.
PhotometricCalibration read_photometric_calibration(const std::filesystem::path& scanner_file);

/// Parses a response: a number, gamma of a power law; a curve as in curve_named; or a scanner file
/// (response_values and response_light suffice). Throws Error if gamma is out of range
/// (`name`: the number's name in the message) or the file has no response.
Response response_named(const std::string& text, const std::string& name);

/// Writes the scanner file `from` to `to` (which may be the same) with the entries of `calibration`
/// replaced and all others unchanged, including unknown ones. Without `from`, the new file has only
/// the calibration. Throws Error unless both or neither end in .xml.
void write_photometric_calibration(const std::optional<std::filesystem::path>& from,
                                   const std::filesystem::path& to,
                                   const PhotometricCalibration& calibration);

}  // namespace slipstream
