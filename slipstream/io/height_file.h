#pragma once

#include <filesystem>

#include "slipstream/geometry/height_calibration.h"

namespace slipstream {

/// A calibration of heights as a NumPy file of 32-bit float: rows x 5 columns, the members of each
/// pixel's HeightCurve one after the other. Throws Error for an ending other than .npy.
void write_height_curves(const std::filesystem::path& path, const Image<HeightCurve>& curves);

/// Throws Error, naming the file, where it is another or its numbers are no calibration's.
Image<HeightCurve> read_height_curves(const std::filesystem::path& path);

}  // namespace slipstream
