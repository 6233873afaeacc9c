// Reads and writes OpenCV's FileStorage files, YAML and XML.
#include "io/opencv_storage.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <pugixml.hpp>
#include <yaml-cpp/yaml.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/matrix_files.h"
#include "io/unique_keys.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// OpenCV writes NaN as .Nan and infinity as .Inf.
std::optional<double> number_from(std::string_view text) {
  if (text == ".Nan" || text == ".nan" || text == ".NaN") return nan;
  if (text.ends_with(".Inf") || text.ends_with(".inf")) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return text.starts_with('-') ? -infinity : infinity;
  }
  return number_in<double>(text);
}

/// A matrix of these texts; rows is 0 if one is not a number or their count is not rows x columns.
StoredMatrix matrix_from(std::string_view rows, std::string_view columns,
                         const std::vector<std::string>& data) {
  StoredMatrix matrix{number_in<int>(rows).value_or(0), number_in<int>(columns).value_or(0)};

  for (const std::string& text : data) {
    const std::optional<double> number = number_from(text);
    if (!number) return {};
    matrix.numbers.push_back(*number);
  }

  // As double, since the product of two damaged numbers may overflow.
  const auto count = static_cast<double>(data.size());
  const bool whole =
      matrix.rows >= 1 && matrix.columns >= 1 && 1.0 * matrix.rows * matrix.columns == count;

  return whole ? matrix : StoredMatrix();
}

/// A number, or otherwise a text.
StoredMatrix scalar_from(const std::string& text) {
  StoredMatrix entry = matrix_from("1", "1", {text});
  if (entry.rows == 0) entry.text = text;
  return entry;
}

StoredMatrix entry_from(const YAML::Node& node) {
  if (node.IsScalar()) return scalar_from(node.Scalar());
  if (!node.IsMap() || !node["rows"] || !node["cols"] || !node["data"]) return {};

  std::vector<std::string> data;
  for (const YAML::Node& number : node["data"]) data.push_back(number.Scalar());

  return matrix_from(node["rows"].Scalar(), node["cols"].Scalar(), data);
}

/// Returns nullopt, or throws Error, if it is not such a file.
std::optional<StoredEntries> entries_from_yaml(std::string text) {
  // OpenCV's first line, "%YAML:1.0", is not YAML.
  if (text.starts_with("%YAML")) text.erase(0, std::min(text.find('\n'), text.size()));

  const YAML::Node root = yaml_document(text);
  if (!root.IsMap()) return std::nullopt;

  StoredEntries entries;
  for (const auto& entry : root) entries[entry.first.Scalar()] = entry_from(entry.second);
  return entries;
}

StoredMatrix entry_from(const pugi::xml_node& node) {
  const auto is_element = [](const pugi::xml_node& child) {
    return child.type() == pugi::node_element;
  };

  if (!node.find_child(is_element)) return scalar_from(node.text().get());

  std::istringstream words(node.child("data").text().get());
  return matrix_from(node.child("rows").text().get(), node.child("cols").text().get(),
                     {std::istream_iterator<std::string>(words), {}});
}

/// Refuses two elements of one name, other than the items of a list. `text`: of the file.
void require_unique_elements(const pugi::xml_node& parent, const std::string& text) {
  std::set<std::string> keys;
  for (const pugi::xml_node& node : parent.children()) {
    const bool is_item = node.type() != pugi::node_element || node.name() == std::string_view("_");
    if (is_item || keys.insert(node.name()).second) continue;

    // pugixml knows the element's offset, the message names its line.
    const std::ptrdiff_t end = std::clamp(node.offset_debug(), std::ptrdiff_t{0}, std::ssize(text));
    add_key(keys, node.name(), std::count(text.begin(), text.begin() + end, '\n') + 1);
  }
}

std::optional<StoredEntries> entries_from_xml(const std::string& text) {
  pugi::xml_document document;
  const bool whole = document.load_buffer(text.data(), text.size());
  const pugi::xml_node root = document.child("opencv_storage");
  if (!whole || !root) return std::nullopt;

  StoredEntries entries;
  require_unique_elements(document, text);
  require_unique_elements(root, text);

  for (const pugi::xml_node& node : root.children()) {
    require_unique_elements(node, text);
    entries[node.name()] = entry_from(node);
  }

  return entries;
}

bool is_xml(const std::string& text) {
  return text.find_first_not_of(" \t\r\n") == text.find('<');
}

/// Double-quoted YAML, on one line.
std::string quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }

  return quoted + '"';
}

std::string yaml_of(const std::string& name, const StoredMatrix& entry) {
  if (entry.rows == 0) return fmt::format("{}: {}\n", name, quoted(entry.text));
  if (entry.numbers.size() == 1) return fmt::format("{}: {}\n", name, entry.numbers[0]);
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
                     name, entry.rows, entry.columns, fmt::join(entry.numbers, ", "));
}

/// Top-level entries of YAML start in the first column, their contents do not.
std::string with_yaml_entries(const std::string& text, const StoredEntries& entries) {
  std::istringstream lines(text);
  std::string kept, end;
  bool dropping = false;

  for (std::string line; std::getline(lines, line);) {
    const bool starts_entry = !line.empty() && line[0] != ' ' && line[0] != '\t';
    if (starts_entry) dropping = entries.contains(line.substr(0, line.find(':')));

    // The end of the document follows the added entries.
    if (line == "...") {
      end = "...\n";
    } else if (!dropping) {
      kept += line + '\n';
    }
  }

  for (const auto& [name, entry] : entries) {
    if (!entry.empty()) kept += yaml_of(name, entry);
  }

  return kept + end;
}

std::string with_xml_entries(const std::string& text, const StoredEntries& entries) {
  pugi::xml_document document;
  document.load_buffer(text.data(), text.size(), pugi::parse_full);
  pugi::xml_node root = document.child("opencv_storage");

  for (const auto& [name, entry] : entries) {
    while (root.remove_child(name.c_str())) {
    }
    if (entry.empty()) continue;

    pugi::xml_node node = root.append_child(name.c_str());
    const std::string numbers = fmt::format("{}", fmt::join(entry.numbers, " "));

    if (entry.numbers.size() <= 1) {
      node.text().set((entry.text + numbers).c_str());
      continue;
    }

    node.append_attribute("type_id").set_value("opencv-matrix");
    node.append_child("rows").text().set(entry.rows);
    node.append_child("cols").text().set(entry.columns);
    node.append_child("dt").text().set("d");
    node.append_child("data").text().set(numbers.c_str());
  }

  std::ostringstream changed;
  document.save(changed, "  ");
  return changed.str();
}

/// The file's text; for a recording, two files and matrices by themselves, their scanner's.
std::string text_in(const fs::path& path) {
  if (scanner_files(path).size() == 2 || has_matrices(path)) return text_of(read_scanner(path));

  if (is_recording(path)) {
    const RecordingReader recording(path);
    if (const auto& scanner = recording.header().scanner) return text_of(*scanner);
    throw Error(fmt::format("{}: the recording contains no scanner", path.string()));
  }

  return read_text(path);
}

}  // namespace

StoredEntries opencv_entries(const std::string& text, const std::string& name) {
  try {
    auto entries = is_xml(text) ? entries_from_xml(text) : entries_from_yaml(text);
    if (entries) return *std::move(entries);
  } catch (const RepeatedKey& repeated) {
    throw RepeatedKey(fmt::format("{}: {}", name, repeated.what()));
  } catch (const Error&) {
    // Rejected below, like any other file.
  }

  throw Error(fmt::format("{}: not a scanner file; expected OpenCV's YAML or XML", name));
}

StoredEntries read_opencv_storage(const fs::path& path) {
  return opencv_entries(text_in(path), path.string());
}

std::string new_storage(const StoredEntries& entries, bool xml) {
  return xml ? with_xml_entries("<opencv_storage/>", entries)
             : with_yaml_entries("%YAML:1.0\n---\n", entries);
}

std::string with_entries(const std::string& text, const StoredEntries& entries,
                         const std::string& name) {
  const StoredEntries before = opencv_entries(text, name);
  std::string changed =
      is_xml(text) ? with_xml_entries(text, entries) : with_yaml_entries(text, entries);

  const auto refuse = [&](const std::string& entry) {
    throw Error(fmt::format("{}: cannot replace {}; each entry must begin a line", name, entry));
  };

  // Reads the changed text again: replacing lines fails for some valid layouts of YAML.
  StoredEntries after;
  try {
    after = opencv_entries(changed, name);
  } catch (const Error&) {
    refuse("an entry");
  }

  for (const auto& [key, entry] : entries) {
    const auto found = after.find(key);
    if (found == after.end() ? !entry.empty() : entry.empty() || found->second != entry)
      refuse(key);
  }

  // No other entry may be lost.
  for (const auto& [key, entry] : before) {
    if (!entries.contains(key) && !after.contains(key)) refuse(key);
  }

  return changed;
}

void write_entries(const std::optional<fs::path>& from, const fs::path& to,
                   const StoredEntries& entries) {
  const bool xml = lower_case_extension(to) == ".xml";

  const auto is_of_xml = [](const fs::path& path) {
    return scanner_files(path).size() == 1 && lower_case_extension(path) == ".xml";
  };

  throw_if(from && is_of_xml(*from) != xml, "{}: {} is {}; use the same ending for the output",
           to.string(), from.value_or("").string(), xml ? "YAML" : "XML");

  write_file(
      to, from ? with_entries(text_in(*from), entries, from->string()) : new_storage(entries, xml));
}

}  // namespace slipstream
