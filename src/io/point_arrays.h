#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// Arrays of points in the text files and NumPy files of other programs.
namespace slipstream {

/// An array of a file: rows of equal length. Of an array of three dimensions, the rows of its first
/// layer come first.
struct PointArray {
  std::string name;                  ///< of the array or, without its ending, of the file
  std::vector<std::string> names{};  ///< of the columns; empty if the file does not say
  std::vector<std::string> poses{};  ///< of each row, of a column with texts; usually empty
  int layers = 1;                    ///< of an array of three dimensions, its first
  int columns = 0;
  std::vector<double> numbers{};  ///< row by row; NaN where a field is empty

  [[nodiscard]] int rows() const { return static_cast<int>(numbers.size()) / columns; }
  [[nodiscard]] double at(int row, int column) const { return numbers[row * columns + column]; }
};

/// The lower-case words of a name, with its numbers: "projPoints_1" is proj, points and 1.
std::vector<std::string> words_and_numbers(std::string_view name);

/// The arrays of a text file (.txt, .csv, .dat), an .npy or .npz file, or a folder of them, in the
/// order of their names. Throws Error with file and line for anything but numbers.
std::vector<PointArray> read_point_arrays(const std::filesystem::path& path);

}  // namespace slipstream
