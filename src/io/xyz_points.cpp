#include "io/xyz_points.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace {

/// The columns that a line of names declares, as PLY calls them; empty unless x, y and z are there.
std::vector<std::string> names_in(std::string_view line) {
  std::vector<std::string> names;
  for (const std::string_view word : words_of(line, " \t,;/#\"")) {
    names.push_back(usual_name(std::string(word)));
  }

  const auto has = [&](const char* name) { return std::ranges::find(names, name) != names.end(); };
  return has("x") && has("y") && has("z") ? names : std::vector<std::string>();
}

/// The columns of a text without names, by their number: those of write_cloud, or x, y, z and
/// perhaps a colour.
std::vector<std::string> names_of_columns(std::size_t count, bool coloured) {
  static constexpr std::array place{"x", "y", "z", "intensity"};
  static constexpr std::array colour{"red", "green", "blue"};
  static constexpr std::array sigma{"sigma_coordinate", "sigma_x", "sigma_y", "sigma_z"};

  std::vector<std::string> names(count);

  // By write_cloud: the intensity, and then 3 columns of a normal, 4 of sigma, or both.
  const bool ours = !coloured && (count == 4 || count == 7 || count == 8 || count == 11);

  std::copy_n(place.begin(), std::min<std::size_t>(count, ours ? 4 : 3), names.begin());
  if (coloured) std::copy(colour.begin(), colour.end(), names.begin() + 3);
  if (ours && count >= 8) std::copy(sigma.begin(), sigma.end(), names.end() - 4);
  return names;
}

/// The columns of a .pts file, whose format says what seven are: the intensity, of -2048 to 2047,
/// and a colour.
std::vector<std::string> names_of_pts_columns(std::size_t count, bool coloured) {
  if (count == 7) return {"x", "y", "z", "", "red", "green", "blue"};
  return names_of_columns(count, coloured);
}

/// Programs may write a plus before a number.
std::optional<double> number_of(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return number_in<double>(word);
}

/// Throws Error for a line such as "1,5;2,5;3,5": taken apart at its commas, it has six whole
/// numbers. Each of its words has one comma between two digits, or none.
void refuse_decimal_commas(std::string_view line, std::size_t line_number) {
  const std::vector<std::string_view> words = words_of(line, " \t;");
  std::string_view with_comma;

  for (const std::string_view word : words) {
    const std::size_t comma = word.find(',');
    if (comma == word.npos) continue;

    const bool is_inside = comma > 0 && comma + 1 < word.size() && comma == word.rfind(',');
    if (!is_inside) return;
    with_comma = word;
  }

  throw_if(words.size() > 1 && !with_comma.empty(),
           "line {}: '{}' has a decimal comma; write numbers with a decimal point", line_number,
           with_comma.substr(0, 20));
}

/// The largest of a line's fourth to sixth words if they are whole numbers up to 255; otherwise -1.
int colour_level(const std::vector<std::string_view>& words) {
  int largest = words.size() < 6 ? -1 : 0;
  for (std::size_t k = 3; k < 6 && largest >= 0; ++k) {
    const auto level = number_in<std::uint8_t>(words[k]);
    largest = level ? std::max<int>(largest, *level) : -1;
  }
  return largest;
}

/// `names_by_number`: the columns of a text without names, see names_of_columns.
StoredPoints points_in_lines(std::span<const std::uint8_t> bytes,
                             std::vector<std::string> (*names_by_number)(std::size_t, bool)) {
  // 1. The lines as numbers.
  NumberReader lines(without_mark(bytes));
  std::vector<std::string> names;
  std::vector<std::uint8_t> numbers;

  std::size_t columns = 0, points = 0, headers = 0;
  int lowest = 255, highest = 0;  // of the lines' colour levels

  for (std::size_t line_number = 1; !lines.left().empty(); ++line_number) {
    const std::string_view line = lines.line();
    const std::vector<std::string_view> words = words_of(line, " \t,;");
    if (words.empty()) continue;

    const bool comment = words[0].starts_with('#') || words[0].starts_with("//");

    // A line of names, or of the number of points.
    const bool header = columns == 0 && headers < 2 && (words.size() < 3 || !number_of(words[0]));

    if (comment || header) {
      headers += comment ? 0 : 1;
      if (columns == 0 && names.empty()) names = names_in(line);
      continue;
    }

    // The first line of numbers gives their count for all.
    if (words.size() != columns) refuse_decimal_commas(line, line_number);
    if (columns == 0) columns = words.size();
    throw_if(words.size() != columns, "line {}: expected {} numbers, as in the first line",
             line_number, columns);

    for (const std::string_view word : words) {
      const auto number = number_of(word);
      throw_if(!number, "line {}: '{}' is not a number", line_number, word.substr(0, 20));
      append_numbers(numbers, *number);
    }

    lowest = std::min(lowest, colour_level(words));
    highest = std::max(highest, colour_level(words));
    ++points;
  }

  // 2. The columns' names, from a line of names or from their number.
  // Whole numbers that are all 0 or 1 are rather a normal.
  if (names.size() != columns) names = names_by_number(columns, lowest >= 0 && highest > 1);

  // 3. The same numbers as a binary element.
  PointElement element{.name = "vertex", .count = points, .properties = {}};
  for (const std::string& name : names) element.properties.push_back({name, NumberType::float64});

  NumberReader reader(numbers);
  reader.set_format("binary_little_endian");

  StoredPoints stored;
  read_element(element, reader, stored);

  return stored;
}

}  // namespace

StoredPoints xyz_points(std::span<const std::uint8_t> bytes) {
  return points_in_lines(bytes, names_of_columns);
}

StoredPoints pts_points(std::span<const std::uint8_t> bytes) {
  return points_in_lines(bytes, names_of_pts_columns);
}

}  // namespace slipstream
