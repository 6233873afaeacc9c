#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace slipstream {

/// Bad input: a file that is missing, truncated or of another size, a parameter outside its domain,
/// a singular calibration. The message is one line that names the thing, its value and what would
/// be right. The program prints it and exits 2.
class Error : public std::runtime_error {
 public:
  /// Line breaks, which the words of files may have, become spaces.
  explicit Error(std::string message) : std::runtime_error(one_line(std::move(message))) {}

 private:
  static std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
  }
};

/// A failure of the world that no other input would mend: disk full, folder not writable, camera
/// gone. The program prints it and exits 1.
class WorldError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws Error, "name value is out of range; range", unless the value `holds`.
void require_in_range(bool holds, std::string_view name, double value, std::string_view range);

/// The least number of characters to insert, remove or replace that turns one into the other.
std::size_t edit_distance(std::string_view from, std::string_view to);

/// "; did you mean pmp?" for the end of a message: the known name nearest to an unknown one. Empty
/// if none is near.
template <class Names>
std::string did_you_mean(std::string_view name, const Names& known) {
  std::string_view nearest;
  std::size_t least = name.size() / 3 + 2;  // more edits than a typo has
  for (const auto& candidate : known) {
    const std::string_view other = candidate;
    const bool begun = name.size() >= 3 && other.starts_with(name);
    const std::size_t distance = begun ? 1 : edit_distance(name, other);
    if (distance >= least || distance >= other.size()) continue;
    least = distance;
    nearest = other;
  }
  return nearest.empty() ? "" : "; did you mean " + std::string(nearest) + "?";
}

}  // namespace slipstream
