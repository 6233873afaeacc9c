#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

// OpenCV FileStorage files with any entries.
namespace slipstream {

/// An entry of an OpenCV FileStorage file: a matrix, a number (1x1) or a line of text (rows and
/// columns 0).
struct StoredMatrix {
  int rows = 0;
  int columns = 0;
  std::vector<double> numbers{};  ///< row by row; may be NaN
  std::string text{};             ///< the line of text; empty for numbers

  [[nodiscard]] bool empty() const { return rows == 0 && text.empty(); }
  friend bool operator==(const StoredMatrix&, const StoredMatrix&) = default;
};

/// The top-level entries of a FileStorage file by name.
using StoredEntries = std::map<std::string, StoredMatrix>;

/// The entries of a FileStorage file, YAML or XML. Does not use OpenCV's reader, which aborts the
/// program on damaged XML. Accepts a recording with a scanner. Throws Error with the file's name if
/// it is not such a file.
StoredEntries read_opencv_storage(const std::filesystem::path& path);

/// The same for a file's text; `name`: the file's name in messages.
StoredEntries opencv_entries(const std::string& text, const std::string& name);

/// The text of a FileStorage file with all non-empty entries.
std::string new_storage(const StoredEntries& entries, bool xml);

/// Replaces or adds entries in the text of a FileStorage file (YAML or XML); leaves the rest
/// unchanged. Removes empty entries. Throws Error with `name` if the text is not such a file, or
/// its layout does not allow replacing an entry.
std::string with_entries(const std::string& text, const StoredEntries& entries,
                         const std::string& name);

/// Writes the FileStorage file `from` to `to` (which may be the same) with these entries. Without
/// `from`, the new file has only them. Throws Error unless both or neither end in .xml.
void write_entries(const std::optional<std::filesystem::path>& from,
                   const std::filesystem::path& to, const StoredEntries& entries);

}  // namespace slipstream
