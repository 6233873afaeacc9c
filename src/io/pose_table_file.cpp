#include "io/pose_table_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "base/numbers.h"
#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_elements.h"
#include "io/unique_keys.h"

namespace slipstream {
namespace {

/// A pose's numbers with the names beside them, which may be empty.
struct NamedNumbers {
  std::string pose;  ///< name
  std::vector<std::pair<std::string, double>> numbers;
};

using Names = std::vector<std::string>;

/// A name without case, unit and separators: "Pos_X [mm]" is "posx".
std::string plain_name(std::string_view text) {
  std::string plain;
  for (const char letter : text.substr(0, text.find_first_of("[("))) {
    const auto code = static_cast<unsigned char>(letter);
    if (std::isalnum(code) != 0) plain += static_cast<char>(std::tolower(code));
  }
  for (const std::string_view unit : {"mm", "deg", "rad"}) {
    if (plain.size() > unit.size() && plain.ends_with(unit)) {
      plain.resize(plain.size() - unit.size());
    }
  }
  if (plain.size() == 4 && plain.starts_with("pos")) plain.erase(0, 3);
  return plain;
}

/// The numbers with these names, in their order; empty unless all are there. Of a name that comes
/// twice the last: in a FANUC program P[1] is before the pose's P.
std::vector<double> numbers_named(const NamedNumbers& entry, const Names& names) {
  std::vector<double> found;
  for (const std::string& name : names) {
    std::optional<double> last;
    for (const auto& [own, number] : entry.numbers) {
      if (own == name) last = number;
    }
    if (last) found.push_back(*last);
  }
  return found.size() == names.size() ? found : std::vector<double>();
}

std::vector<double> first_named(const NamedNumbers& entry, const std::vector<Names>& choices) {
  for (const Names& names : choices) {
    std::vector<double> found = numbers_named(entry, names);
    if (!found.empty()) return found;
  }
  return {};
}

/// The row of a table: by the names if they are known, else by the order.
std::vector<double> row_from(const NamedNumbers& entry) {
  static const std::vector<Names> positions{
      {"x", "y", "z"}, {"tx", "ty", "tz"}, {"px", "py", "pz"}};
  static const std::vector<Names> rotations{
      {"qw", "qx", "qy", "qz"}, {"q1", "q2", "q3", "q4"}, {"q0", "q1", "q2", "q3"},
      {"rx", "ry", "rz"},       {"a", "b", "c"},          {"w", "p", "r"},
      {"o", "a", "t"},          {"u", "v", "w"},          {"roll", "pitch", "yaw"}};

  std::vector<double> row = first_named(entry, positions);
  const std::vector<double> rotation = first_named(entry, rotations);
  if (!row.empty() && !rotation.empty()) {
    row.insert(row.end(), rotation.begin(), rotation.end());
    return row;
  }

  // By the order, unless the numbers have names of their own: those of joints, or of anything.
  const bool has_position = !row.empty();
  Names names;
  row.clear();
  for (const auto& [name, number] : entry.numbers) {
    row.push_back(number);
    if (!name.empty()) names.push_back(name);
  }
  const bool of_joints = std::ranges::any_of(
      names, [](const std::string& name) { return name == "a1" || name == "j1" || name == "jt1"; });
  throw_if(!has_position && names.size() > 1 && (of_joints || row.size() < 12),
           "the numbers {} are not those of a pose, perhaps of joints; expected x, y, z and a "
           "rotation",
           fmt::join(names, ", "));

  // Position, quaternion, axis configuration and external axes of an ABB controller, which have no
  // names; the first may have the pose's.
  constexpr std::size_t robtarget = 17;
  if (row.size() == robtarget && entry.numbers[1].first.empty()) row.resize(7);

  if (row.size() == 12) row.insert(row.end(), {0, 0, 0, 1});
  throw_if(row.size() != 6 && row.size() != 7 && row.size() != 16,
           "{} numbers; expected 6 (position and three angles), 7 (position and quaternion), 12 or "
           "16 (matrix), or a line of column names such as name,x,y,z,rx,ry,rz",
           row.size());
  return row;
}

std::optional<double> number_of_word(std::string_view word) {
  return number_in<double>(word.starts_with('+') ? word.substr(1) : word);
}

/// Separators of columns: those that the line of names has, so that names may have blanks.
const char* separators_of(std::string_view line) {
  if (line.find(';') != line.npos) return ";\r";
  if (line.find(',') != line.npos) return ",\r";
  if (line.find('\t') != line.npos) return "\t\r";
  return " \r";
}

/// The text of a cell, which may have blanks, without those around it and without quotes.
std::string unquoted(std::string_view cell) {
  constexpr std::string_view around = " \t\"'";
  const std::size_t first = cell.find_first_not_of(around);
  if (first == cell.npos) return "";
  return std::string(cell.substr(first, cell.find_last_not_of(around) + 1 - first));
}

/// A line under column names.
NamedNumbers numbers_in_columns(const std::string& line, const Names& columns,
                                const char* separators) {
  const auto cells = words_of(line, separators);
  throw_if(cells.size() != columns.size(), "{} columns; expected {}", cells.size(), columns.size());

  NamedNumbers entry;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (columns[i] == "name") {
      entry.pose = unquoted(cells[i]);
      continue;
    }
    if (columns[i].empty()) continue;

    const auto words = words_of(cells[i]);
    const std::optional<double> number = number_of_word(words.empty() ? "" : words.front());
    if (number) entry.numbers.emplace_back(columns[i], *number);
  }
  return entry;
}

/// Whether a word may name a pose: motions of KRL, RAPID and URScript stand in the same place.
bool names_a_pose(std::string_view word) {
  static const std::set<std::string, std::less<>> motions{
      "ptp", "lin", "circ", "sptp", "slin", "scirc", "movej", "movel", "movep", "movec"};
  return !word.empty() && !motions.contains(plain_name(word));
}

/// The line up to the end of a pose of URScript, p[x,y,z,rx,ry,rz], and without the `p`: numbers
/// after it are a motion's speed. The whole line if it has none.
std::string without_speed(const std::string& line) {
  const std::size_t at = line.find("p[");
  if (at == line.npos) return line;
  if (at > 0 && std::isalnum(static_cast<unsigned char>(line[at - 1])) != 0) return line;

  // Five commas: others have elements of arrays called p.
  const std::size_t end = std::min(line.find(']', at), line.size());
  const std::string pose = line.substr(at + 1, end - at - 1);
  return std::ranges::count(pose, ',') == 5 ? line.substr(0, at) + pose : line;
}

/// A line that has its names beside its numbers, or none.
NamedNumbers numbers_in_line(const std::string& line) {
  NamedNumbers entry;
  const std::string pose = without_speed(line);
  std::string_view before;
  for (const std::string_view word : words_of(pose, " \t\r,;{}[]()=:\"'")) {
    const std::optional<double> number = number_of_word(word);
    if (!number) {
      // The last word before the first number names the pose, unless it names a coordinate.
      if (entry.numbers.empty() && names_a_pose(before)) entry.pose = before;
      before = word;
      continue;
    }

    entry.numbers.emplace_back(plain_name(before), *number);
    const bool is_first = entry.numbers.size() == 1;
    if (is_first && entry.numbers.front().first != "x" && names_a_pose(before)) entry.pose = before;
    before = {};
  }
  return entry;
}

/// Blank lines, and comments of tables and of robots' programs.
bool is_comment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == line.npos) return true;
  line.remove_prefix(first);

  // KRL and AS. In a table of semicolons a blank cell comes before a number, or before the name of
  // a column, which a semicolon ends.
  const std::size_t end = line.find_first_of("; \t\r", 1);
  const bool krl = line.size() > 1 && line[0] == ';' &&
                   std::isalpha(static_cast<unsigned char>(line[1])) != 0 &&
                   (end == line.npos || line[end] != ';');
  return krl || line.starts_with("//") || line.find_first_of("#&!") == 0;
}

/// Throws Error for a line of a program whose numbers are not one pose: in KRL, RAPID, URScript,
/// DRL, AS or a log.
void require_one_pose(const std::string& line) {
  const auto refuse_if = [](bool refused, const char* what) {
    throw_if(refused, "{}; expected poses of the tool in the robot's base: x, y, z and a rotation",
             what);
  };
  static const std::map<std::string, const char*, std::less<>> others{
      {"axis", "joint angles"},         {"e6axis", "joint angles"},
      {"joint", "joint angles"},        {"joints", "joint angles"},
      {"ppoint", "joint angles"},       {"jointtarget", "joint angles"},
      {"moveabsj", "joint angles"},     {"circ", "a circular motion"},
      {"scirc", "a circular motion"},   {"movec", "a circular motion"},
      {"amovec", "a circular motion"},  {"ptprel", "a relative motion"},
      {"linrel", "a relative motion"},  {"circrel", "a relative motion"},
      {"reltool", "a relative motion"}, {"offs", "a relative motion"}};

  // A list without the p of a pose, movej([0, ...]), DRL's posj(0, ...) and AS's #[0, ...].
  std::string dense = line;
  std::erase_if(dense, [](char letter) { return letter == ' ' || letter == '\t'; });
  for (const char* const list : {"j([", "posj(", "#["}) {
    refuse_if(dense.find(list) != dense.npos, "joint angles");
  }

  for (const std::string_view word : words_of(line, " \t\r,;{}[]()=:")) {
    const auto other = others.find(plain_name(word));
    if (other != others.end()) refuse_if(true, other->second);
  }
}

bool has_numbers(const std::string& line) {
  return std::ranges::any_of(words_of(line, " \t\r,;{}[]()=:"), [](std::string_view word) {
    return number_of_word(word).has_value();
  });
}

Names plain_names(std::string_view line, const char* separators) {
  Names names;
  for (const std::string_view word : words_of(line, separators)) names.push_back(plain_name(word));
  return names;
}

void add_row(PoseTable& table, const NamedNumbers& entry) {
  std::vector<double> row = row_from(entry);
  const std::size_t usual = table.rows.empty() ? row.size() : table.rows.front().size();
  throw_if(row.size() != usual, "{} numbers of a pose; those before have {}", row.size(), usual);
  table.rows.push_back(std::move(row));
  table.names.push_back(entry.pose);
}

PoseTable table_in_lines(const std::string& text, std::string_view named_columns) {
  PoseTable table;
  std::string_view left = text;
  const char* separators = ",; \t\r";
  Names columns = plain_names(named_columns, ",");
  bool begun = false;

  for (int number = 1; !left.empty(); ++number) {
    const int begin = number;
    std::string line(take_until(left, '\n'));
    throw_if(line.starts_with("///") && line.find("PULSE") != line.npos,
             "line {}: positions in pulses; expected poses of the tool, as of ///POSTYPE BASE",
             number);
    if (is_comment(line)) continue;

    // A pose of several lines, in braces.
    while (line.find('{') != line.npos && line.find('}') == line.npos && !left.empty()) {
      line += fmt::format(" {}", take_until(left, '\n'));
      ++number;
    }

    // 1. The line of names, at least as many as a pose has numbers.
    const bool first = !std::exchange(begun, true);
    if (first && !has_numbers(line)) {
      const Names names = plain_names(line, separators_of(line));
      if (columns.empty() && names.size() >= 6) {
        separators = separators_of(line);
        columns = names;
      }
      continue;
    }

    // 2. Numbers with commas instead of points.
    const bool by_semicolons =
        std::ranges::count(line, ';') >= 5 && line.find_first_of("[{(.") == line.npos;
    if (by_semicolons) std::ranges::replace(line, ',', '.');

    naming(fmt::format("line {}", begin), [&] {
      if (!columns.empty()) return add_row(table, numbers_in_columns(line, columns, separators));

      // Programs of robots have other lines too.
      const NamedNumbers entry = numbers_in_line(line);
      if (entry.numbers.size() < 6) return;
      require_one_pose(line);
      add_row(table, entry);
    });
  }
  return table;
}

bool begins_with_any(const std::string& text, std::initializer_list<std::string_view> starts) {
  return std::ranges::any_of(starts,
                             [&](std::string_view start) { return text.starts_with(start); });
}

/// Appends all numbers of a node. `inside`: its key.
void collect(const YAML::Node& node, const std::string& inside, NamedNumbers& entry,
             int depth = 0) {
  throw_if(depth > 4, "line {}: lists within lists", node.Mark().line + 1);
  if (node.IsScalar()) {
    if (inside == "name" || inside == "id") {
      entry.pose = node.Scalar();
      return;
    }

    const std::optional<double> number = number_of_word(node.Scalar());
    if (number) entry.numbers.emplace_back(inside, *number);
    return;
  }

  if (node.IsSequence()) {
    for (const YAML::Node& part : node)
      collect(part, node.size() > 1 ? "" : inside, entry, depth + 1);
    return;
  }

  // The position goes first, whatever the order of the keys.
  for (const bool rotation : {false, true}) {
    for (const auto& child : node) {
      if (!child.first.IsScalar()) continue;
      std::string key = plain_name(child.first.Scalar());
      throw_if(key == "name" && child.second.IsSequence(),
               "a list of names, as of joints; expected poses of the tool");
      if (begins_with_any(key, {"joint", "axis", "axes", "actualq", "velocity", "effort"}) ||
          key == "q") {
        continue;
      }
      if (begins_with_any(key, {"rot", "orient", "quat", "angle", "euler"}) != rotation) continue;
      if (begins_with_any(inside, {"orient", "quat", "rot"})) key.insert(0, "q");
      collect(child.second, key, entry, depth + 1);
    }
  }
}

PoseTable table_in_yaml(const std::string& text) {
  YAML::Node list = yaml_document(text);

  // Under a key.
  if (list.IsMap()) {
    for (const auto& child : list) {
      if (child.second.IsSequence() && child.second.size() > 0 && !child.second[0].IsScalar()) {
        list.reset(child.second);
        break;
      }
    }
  }
  throw_if(!list.IsSequence(), "expected a list of poses");

  PoseTable table;
  for (const YAML::Node& item : list) {
    NamedNumbers entry;
    naming(fmt::format("line {}", item.Mark().line + 1), [&] {
      collect(item, "", entry);
      add_row(table, entry);
    });
  }
  return table;
}

/// Drops names that do not tell the poses apart.
void check_names(PoseTable& table) {
  const std::set<std::string> different(table.names.begin(), table.names.end());
  if (table.names.size() > 1 && different.size() == 1) return table.names.clear();
  if (different.contains("")) return table.names.clear();

  std::set<std::string> seen;
  for (const std::string& name : table.names) {
    throw_if(!seen.insert(name).second, "two poses are named {}", printable(name));
  }
}

}  // namespace

PoseTable pose_table_in_text(const std::string& text, bool is_yaml, std::string_view columns,
                             const std::string& name) {
  return naming(name, [&] {
    PoseTable table = is_yaml ? table_in_yaml(text) : table_in_lines(text, columns);
    throw_if(table.rows.empty(), "no poses: expected a pose a line, with 6, 7, 12 or 16 numbers");
    check_names(table);
    return table;
  });
}

PoseTable read_pose_table(const std::filesystem::path& path, std::string_view columns) {
  const std::string ending = lower_case_extension(path);
  return pose_table_in_text(read_text(path), ending == ".yaml" || ending == ".yml", columns,
                            path.string());
}

std::string text_of(const PoseTable& table, std::string_view columns) {
  std::string text = fmt::format("{}\n", columns);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::string name = table.names.empty() ? "" : table.names[i] + ",";
    text += fmt::format("{}{:.9g}\n", name, fmt::join(table.rows[i], ","));
  }
  return text;
}

}  // namespace slipstream
