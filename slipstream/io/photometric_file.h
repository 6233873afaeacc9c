#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace slipstream {

/// What a scanner file says of light and sensor; grey levels of an 8-bit camera.
struct PhotometricCalibration {
  std::optional<double> ambient;         ///< beta, `ambient_light`: -255 to 255
  std::optional<double> noise_variance;  ///< sigma_w^2, rounding included, `noise_variance`: > 0
};

/// Throws Error, naming file and entry, for one that is not a number or out of range.
PhotometricCalibration read_photometric_calibration(const std::filesystem::path& scanner_file);

/// The same of such a file's text; `name` is what a message calls it.
PhotometricCalibration photometric_calibration_from(const std::string& text,
                                                    const std::string& name);

/// The text of such a file with what the calibration has in place of what it says, and all else as
/// it was. Throws Error, calling it `name`, where it is no such text.
std::string with_photometric_calibration(const std::string& text,
                                         const PhotometricCalibration& calibration,
                                         const std::string& name);

/// Writes the scanner file `from` to `to` (which may be the same) with what the calibration has in
/// place of what the file says, and all else as it was. `from` may be missing: the new file then
/// holds the calibration alone. Throws Error where both names do not end alike in .xml or not.
void write_photometric_calibration(const std::optional<std::filesystem::path>& from,
                                   const std::filesystem::path& to,
                                   const PhotometricCalibration& calibration);

}  // namespace slipstream
