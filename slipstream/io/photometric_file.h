#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "slipstream/geometry/scanner.h"
#include "slipstream/io/opencv_storage.h"

namespace slipstream {

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

/// The same of entries that have been read, or are to be written; `name` is what a message calls
/// the file.
PhotometricCalibration photometric_calibration_of(
    const std::map<std::string, StoredMatrix>& entries, const std::string& name);
std::map<std::string, StoredMatrix> entries_of(const PhotometricCalibration& calibration);

}  // namespace slipstream
