#pragma once

#include <filesystem>
#include <map>

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
///     world, mm, to the pixels of either, up to scale (see scanner_of in scanner.h).
/// Distortion may be missing (none) and sizes too. Rotation and translation take the camera's frame
/// to the projector's, mm. What is known of light and sensor, see below, and the line
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

// What a scanner file says of light and sensor, each entry for itself:
//   ambient_light, noise_variance          numbers
//   noise_gain                             a number, 0 where it is missing
//   gamma, gamma_standard_error            of a power law, or of the one nearest to a curve
//   response_values, response_light        a measured curve, two rows of numbers
//   colour_mixture                         3x4, see ColourMixture

/// Reads it from a file that may hold nothing else. Throws Error, naming file and entry, for one
/// that is not of its form or out of range.
PhotometricCalibration read_photometric_calibration(const std::filesystem::path& scanner_file);

/// The response that a text names: a number, gamma of a power law; a curve as curve_named has it;
/// or a scanner file that holds one, of which response_values and response_light are enough. Throws
/// Error, by `name` what a message calls the number, where gamma is out of range, and naming the
/// file where it holds none.
Response response_named(const std::string& text, const std::string& name);

/// Writes the scanner file `from` to `to` (which may be the same) with what the calibration has in
/// place of what the file says, and all else as it was, what slipstream does not know too. `from`
/// may be missing: the new file then holds the calibration alone. Throws Error where both names do
/// not end alike in .xml or not.
void write_photometric_calibration(const std::optional<std::filesystem::path>& from,
                                   const std::filesystem::path& to,
                                   const PhotometricCalibration& calibration);

// The files themselves, whatever their entries are.

/// A matrix or, 1x1, a number of an OpenCV FileStorage file, or a line of text; rows and columns
/// are 0 for what is no matrix.
struct StoredMatrix {
  int rows = 0;
  int columns = 0;
  std::vector<double> numbers{};  ///< row by row; may be NaN
  std::string text{};             ///< of a line of text; else empty

  [[nodiscard]] bool empty() const { return rows == 0 && text.empty(); }
  friend bool operator==(const StoredMatrix&, const StoredMatrix&) = default;
};

/// The entries at the top of a FileStorage file (YAML or XML) by name. OpenCV's own reader is not
/// used: damaged XML ends the program there. A recording serves as well, with the scanner that it
/// holds. Throws Error, naming the file, when it is not such a file.
std::map<std::string, StoredMatrix> read_opencv_storage(const std::filesystem::path& path);

/// The same of such a file's text; `name` is what a message calls it.
std::map<std::string, StoredMatrix> opencv_entries(const std::string& text,
                                                   const std::string& name);

/// The text of a FileStorage file with those entries that are not empty.
std::string new_storage(const std::map<std::string, StoredMatrix>& entries, bool xml);

/// The text of a FileStorage file (YAML or XML) with those entries in place of any of their names
/// and all else as it was. An empty entry is taken away. Throws Error, calling it `name`,
/// when the text is no such file or is laid out so that an entry cannot be replaced.
std::string with_entries(const std::string& text,
                         const std::map<std::string, StoredMatrix>& entries,
                         const std::string& name);

/// Writes the FileStorage file `from` to `to` (which may be the same) with those entries; where
/// `from` is missing, the new file holds them alone. Throws Error where both names do not end alike
/// in .xml or not.
void write_entries(const std::optional<std::filesystem::path>& from,
                   const std::filesystem::path& to,
                   const std::map<std::string, StoredMatrix>& entries);

}  // namespace slipstream
