#include "io/point_arrays.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/npz_file.h"
#include "io/point_elements.h"
#include "io/scan_pictures.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t largest_points = std::uint64_t{1} << 26;

/// Without blanks, quotes and brackets around it.
std::string_view trimmed(std::string_view field) {
  constexpr std::string_view around = " \t\"[]";
  const std::size_t first = std::min(field.find_first_not_of(around), field.size());
  field.remove_prefix(first);
  return field.substr(0, field.find_last_not_of(around) + 1);
}

/// The fields of a line: between its commas, semicolons or tabs, else between blanks.
std::vector<std::string_view> fields_of(std::string_view line) {
  for (const char mark : {',', ';', '\t'}) {
    if (line.find(mark) == line.npos) continue;

    std::vector<std::string_view> fields;
    while (true) {
      const std::size_t end = std::min(line.find(mark), line.size());
      fields.push_back(trimmed(line.substr(0, end)));
      if (end == line.size()) return fields;
      line.remove_prefix(end + 1);
    }
  }
  return words_of(line, " \t\"[]");
}

/// A field as a number: NaN if it says that there is none.
std::optional<double> number_in_field(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  if (const auto number = number_in<double>(field)) return number;

  constexpr std::array<std::string_view, 6> missing{"", "-", "NaN", "NAN", "None", "NA"};
  return std::ranges::count(missing, field) > 0 ? std::optional(nan) : std::nullopt;
}

/// Whether the first field is a name, and all others are numbers.
bool begins_with_name(const std::vector<std::string_view>& fields) {
  return fields.size() > 2 && !number_in_field(fields.front()) &&
         std::all_of(fields.begin() + 1, fields.end(), number_in_field);
}

void add_line(PointArray& array, const std::vector<std::string_view>& fields,
              std::size_t line_number) {
  // 1. Names of the columns come before the first numbers.
  const bool names_pose = begins_with_name(fields);
  if (array.numbers.empty() && !names_pose && !number_in_field(fields.front())) {
    array.names.assign(fields.begin(), fields.end());
    return;
  }

  // 2. The first line of numbers gives their count for all.
  if (array.numbers.empty()) array.columns = static_cast<int>(fields.size());
  throw_if(std::cmp_not_equal(fields.size(), array.columns),
           "line {}: expected {} fields, as in the first line", line_number, array.columns);

  if (names_pose) array.poses.emplace_back(fields.front());
  if (names_pose) array.numbers.push_back(nan);
  for (std::size_t i = names_pose ? 1 : 0; i < fields.size(); ++i) {
    const auto number = number_in_field(fields[i]);
    throw_if(!number, "line {}: '{}' is not a number", line_number, fields[i].substr(0, 20));
    array.numbers.push_back(*number);
  }
}

PointArray array_in_text(std::string name, const std::string& text) {
  PointArray array{.name = std::move(name)};
  std::istringstream lines(text);
  std::size_t line_number = 0;

  for (std::string line; std::getline(lines, line);) {
    ++line_number;

    // numpy.savetxt writes the names of the columns as a comment.
    const bool is_comment = line.starts_with('#');
    if (is_comment) line.erase(0, 1);
    const auto fields = fields_of(line);
    // A line may be blank, or hold only brackets or quotes.
    if (fields.empty() || words_of(line, " \t,;").empty()) continue;
    if (is_comment && !array.numbers.empty()) continue;
    if (is_comment && number_in_field(fields.front())) continue;
    add_line(array, fields, line_number);
  }

  // Names that do not fit are a comment.
  if (std::cmp_not_equal(array.names.size(), array.columns)) array.names.clear();
  throw_if(!array.poses.empty() && std::cmp_not_equal(array.poses.size(), array.rows()),
           "some lines begin with the name of a pose and some with a number");
  return array;
}

/// With rows and columns as in the text files: points are rows. Empty for other shapes.
PointArray array_of(std::string name, NumpyArray&& from) {
  // A dimension of one between others, as OpenCV's corners have, says nothing.
  std::vector<int> shape = from.shape;
  while (shape.size() > 2) {
    const auto one = std::find(shape.begin() + 1, shape.end(), 1);
    if (one == shape.end()) break;
    shape.erase(one);
  }

  if (from.numbers.empty() || shape.size() < 2 || shape.size() > 3) return {};
  PointArray array{.name = std::move(name),
                   .layers = shape.size() == 3 ? shape.front() : 1,
                   .columns = shape.back(),
                   .numbers = std::move(from.numbers)};

  // Some scripts store points as columns: two or three long rows.
  const int rows = shape[shape.size() - 2], columns = array.columns;
  if (rows <= 3 && columns > 8) {
    const std::vector<double> by_columns = array.numbers;
    for (std::size_t i = 0; i < array.numbers.size(); ++i) {
      const auto layer = static_cast<int>(i) / (rows * columns);
      const auto place = static_cast<int>(i) % (rows * columns);
      const int to = layer * rows * columns + place % columns * rows + place / columns;
      array.numbers[to] = by_columns[i];
    }
    array.columns = rows;
  }
  return array;
}

void add_npz(const fs::path& path, std::vector<PointArray>& arrays) {
  for (auto& [name, array] : arrays_of_npz(read_file(path, largest_points), largest_points)) {
    throw_if(array.has_objects,
             "{} holds lists of different lengths as Python objects; save an array for each pose, "
             "e.g. numpy.savez(file, **{{f'camera_{{i}}': p for i, p in enumerate(points)}})",
             name);
    arrays.push_back(array_of(name, std::move(array)));
  }
}

void add_file(const fs::path& path, std::vector<PointArray>& arrays) {
  const std::string ending = lower_case_extension(path), name = path.stem().string();
  naming(path.string(), [&] {
    if (ending == ".npz") return add_npz(path, arrays);
    if (ending == ".npy") {
      arrays.push_back(array_of(name, array_of_npy(read_file(path, largest_points))));
    } else {
      arrays.push_back(array_in_text(name, read_text(path, largest_points)));
    }
  });
}

}  // namespace

std::vector<std::string> words_and_numbers(std::string_view name) {
  enum class Letter { none, lower, upper, digit };
  const auto kind_of = [](unsigned char c) {
    if (std::isdigit(c)) return Letter::digit;
    if (std::isupper(c)) return Letter::upper;
    return std::islower(c) ? Letter::lower : Letter::none;
  };

  std::vector<std::string> words;
  Letter before = Letter::none;
  for (const char c : name) {
    const Letter kind = kind_of(static_cast<unsigned char>(c));
    const bool goes_on = kind == before || (kind == Letter::lower && before == Letter::upper);
    if (kind != Letter::none && !goes_on) words.emplace_back();
    if (kind != Letter::none) {
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    before = kind;
  }
  return words;
}

std::vector<PointArray> read_point_arrays(const fs::path& path) {
  std::vector<PointArray> arrays;
  std::error_code unknown;

  if (fs::is_directory(path, unknown)) {
    constexpr std::array endings{".txt", ".csv", ".dat", ".npy", ".npz"};
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path)) {
      if (std::ranges::count(endings, lower_case_extension(entry.path())) > 0) {
        files.push_back(entry.path());
      }
    }

    std::ranges::sort(files, before_in_order);
    for (const fs::path& file : files) add_file(file, arrays);
  } else {
    add_file(path, arrays);
  }

  std::erase_if(arrays, [](const PointArray& array) { return array.numbers.empty(); });
  throw_if(arrays.empty(),
           "{}: no points; expected .txt, .csv, .dat, .npy or .npz files, with a point in each row",
           path.string());
  return arrays;
}

}  // namespace slipstream
