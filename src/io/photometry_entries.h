#pragma once

#include "io/opencv_storage.h"
#include "slipstream/scanner.h"

// The entries of a scanner file for light and sensor, see slipstream/scanner_file.h.
namespace slipstream {

/// Reads them; all are optional. Throws Error without the file's name for a wrong shape or a value
/// out of range.
PhotometricCalibration photometric_calibration_of(const StoredEntries& entries);

/// The entries of a calibration; empty ones stand for values that it does not have.
StoredEntries entries_of(const PhotometricCalibration& calibration);

}  // namespace slipstream
