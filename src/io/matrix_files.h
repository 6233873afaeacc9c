#pragma once

#include <filesystem>
#include <vector>

#include "io/opencv_storage.h"

// Calibrations that scripts save: NumPy's .npz, and folders of text files with a matrix each.
namespace slipstream {

/// Whether the path is such a calibration: an .npz file or a folder.
bool has_matrices(const std::filesystem::path& path);

/// The files of a calibration: the path, or the folder's files with a matrix, in the order of their
/// names. Throws Error if there are none.
std::vector<std::filesystem::path> matrix_files(const std::filesystem::path& path);

/// The matrices by the names of their arrays or files. Names that say camera or projector, and
/// matrix or distortion, in any order and abbreviation, become slipstream's, as do R and T. Throws
/// Error with the path for a damaged file, and if a matrix is missing.
StoredEntries read_matrices(const std::filesystem::path& path);

}  // namespace slipstream
