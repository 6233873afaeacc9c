#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slipstream {

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
