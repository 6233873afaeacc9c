#include "slipstream/io/opencv_storage.h"

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>

#include <fmt/format.h>
#include <pugixml.hpp>
#include <yaml-cpp/yaml.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using Entries = std::map<std::string, StoredMatrix>;

/// OpenCV writes NaN as .Nan and infinity as .Inf.
std::optional<double> number_from(std::string_view text) {
  if (text == ".Nan" || text == ".nan" || text == ".NaN") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (text.ends_with(".Inf") || text.ends_with(".inf")) {
    return std::numeric_limits<double>::infinity();
  }
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, number);
  return failure == std::errc() && rest == end ? std::optional(number) : std::nullopt;
}

/// A matrix of those texts; without rows where one is no number or there are not rows x columns.
StoredMatrix matrix_from(std::string_view rows, std::string_view columns,
                         const std::vector<std::string>& data) {
  StoredMatrix matrix;
  for (const std::string& text : data) {
    const std::optional<double> number = number_from(text);
    if (!number) return {};
    matrix.numbers.push_back(*number);
  }
  const auto count = static_cast<double>(matrix.numbers.size());
  const double row_count = number_from(rows).value_or(0),
               column_count = number_from(columns).value_or(0);
  if (!(row_count >= 1 && column_count >= 1 && row_count * column_count == count)) return {};
  matrix.rows = static_cast<int>(row_count);
  matrix.columns = static_cast<int>(column_count);
  return matrix;
}

std::string text_of(const YAML::Node& node) {
  return node.IsScalar() ? node.Scalar() : "";
}

StoredMatrix entry_from(const YAML::Node& node) {
  if (node.IsScalar()) return matrix_from("1", "1", {node.Scalar()});
  if (!node.IsMap() || !node["rows"] || !node["cols"] || !node["data"]) return {};
  std::vector<std::string> data;
  for (const YAML::Node& number : node["data"]) data.push_back(text_of(number));
  return matrix_from(text_of(node["rows"]), text_of(node["cols"]), data);
}

std::optional<Entries> entries_from_yaml(std::string text) {
  // OpenCV's first line, "%YAML:1.0", is not YAML.
  if (text.starts_with("%YAML")) text.erase(0, std::min(text.find('\n'), text.size()));
  Entries entries;
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) return std::nullopt;
    for (const auto& entry : root) entries[text_of(entry.first)] = entry_from(entry.second);
  } catch (const YAML::Exception&) {
    return std::nullopt;
  }
  return entries;
}

StoredMatrix entry_from(const pugi::xml_node& node) {
  if (!node.child("data")) return matrix_from("1", "1", {node.text().get()});
  std::istringstream words(node.child("data").text().get());
  std::vector<std::string> data;
  for (std::string word; words >> word;) data.push_back(word);
  return matrix_from(node.child("rows").text().get(), node.child("cols").text().get(), data);
}

std::optional<Entries> entries_from_xml(const std::string& text) {
  pugi::xml_document document;
  if (!document.load_buffer(text.data(), text.size())) return std::nullopt;
  const pugi::xml_node root = document.child("opencv_storage");
  if (!root) return std::nullopt;
  Entries entries;
  for (const pugi::xml_node& node : root.children()) entries[node.name()] = entry_from(node);
  return entries;
}

}  // namespace

Entries read_opencv_storage(const fs::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  const std::string text(bytes.begin(), bytes.end());
  const bool xml = text.find_first_not_of(" \t\r\n") == text.find('<');
  std::optional<Entries> entries = xml ? entries_from_xml(text) : entries_from_yaml(text);
  if (!entries) {
    throw Error(
        fmt::format("{}: not a scanner file; OpenCV's YAML or XML is wanted", path.string()));
  }
  return *std::move(entries);
}

}  // namespace slipstream
