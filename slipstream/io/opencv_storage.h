#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace slipstream {

/// A matrix or, 1x1, a number of an OpenCV FileStorage file; rows and columns are 0 for what is
/// neither.
struct StoredMatrix {
  int rows = 0;
  int columns = 0;
  std::vector<double> numbers;  ///< row by row; may be NaN
};

/// The entries at the top of a FileStorage file (YAML or XML) by name. OpenCV's own reader is not
/// used: damaged XML ends the program there. Throws Error, naming the file, when it is not such a
/// file.
std::map<std::string, StoredMatrix> read_opencv_storage(const std::filesystem::path& path);

}  // namespace slipstream
