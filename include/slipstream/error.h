#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace slipstream {

/// Bad input: a missing or truncated file, one of the wrong size, a parameter out of range, a
/// singular calibration. The message is one line with the thing, its value and the remedy. The
/// program prints it and exits with 2.
///
/// Messages, also warnings and help, name settings and operations in backquotes: a setting by its
/// keyword, alone or with a value, "`order`" or "`order 2,0,1`"; an operation with parentheses,
/// "`calibrate_gamma()`". The program prints these as its flags and commands: "--order", "--order
/// 2,0,1" and "slipstream calibrate gamma".
class Error : public std::runtime_error {
 public:
  /// Line breaks, e.g. in texts from files, become spaces.
  explicit Error(std::string message) : std::runtime_error(one_line(std::move(message))) {}

 private:
  static std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
  }
};

/// A failure of the system, not of the input: disk full, folder not writable, camera disconnected.
/// The program prints it and exits with 1.
class WorldError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws Error "name value is out of range; range" unless `holds`.
void require_in_range(bool holds, std::string_view name, double value, std::string_view range);

/// Levenshtein distance: insertions, deletions and replacements that turn one text into the other.
std::size_t edit_distance(std::string_view from, std::string_view to);

/// A suffix for messages with the known name nearest to an unknown one, e.g. "; did you mean pmp?",
/// or nothing.
template <class Names>
std::string did_you_mean(std::string_view name, const Names& known) {
  std::string_view nearest;
  std::size_t least = name.size() / 3 + 2;  // more edits than a typo has

  for (const auto& candidate : known) {
    const std::string_view other = candidate;
    // A name cut short counts as one edit, however much is missing.
    const bool begun = name.size() >= 3 && other.starts_with(name);
    const std::size_t distance = begun ? 1 : edit_distance(name, other);
    if (distance >= least || distance >= other.size()) continue;

    least = distance;
    nearest = other;
  }

  return nearest.empty() ? "" : "; did you mean " + std::string(nearest) + "?";
}

}  // namespace slipstream
