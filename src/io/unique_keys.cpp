#include "io/unique_keys.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace slipstream {
namespace {

/// `left`: nodes to visit. Aliases may expand without end; a text without them has no more nodes
/// than bytes.
void require_unique_keys(const YAML::Node& node, std::size_t& left, int depth = 0) {
  if (depth == 64) return;
  if (left == 0) throw YAML::ParserException(node.Mark(), "its aliases repeat more than its text");
  --left;

  std::set<std::string> keys;
  for (const auto& item : node) {
    const YAML::Node key = node.IsMap() ? item.first : YAML::Node();
    if (key.IsScalar()) add_key(keys, key.Scalar(), key.Mark().line + 1);
    require_unique_keys(node.IsMap() ? item.second : YAML::Node(item), left, depth + 1);
  }
}

/// Line on which the content of a second document begins; 0 if there is none. YAML::LoadAll does
/// not end on some invalid texts.
int line_of_second_document(const std::string& text) {
  std::istringstream lines(text);
  int number = 0;
  bool has_content = false, after_marker = false;

  for (std::string line; std::getline(lines, line);) {
    ++number;

    const bool marks = (line.starts_with("---") || line.starts_with("...")) &&
                       (line.size() == 3 || std::isspace(static_cast<unsigned char>(line[3])));
    after_marker |= marks && has_content;
    if (marks) line.erase(0, 3);

    // Blank lines, comments and directives do not count as content.
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == line.npos || line[first] == '#' || line.front() == '%') continue;

    if (after_marker) return number;
    has_content = true;
  }

  return 0;
}

}  // namespace

void add_key(std::set<std::string>& keys, const std::string& key, std::ptrdiff_t line) {
  if (keys.insert(key).second) return;
  throw RepeatedKey(fmt::format("line {}: {} is set twice", line, key));
}

YAML::Node yaml_document(const std::string& text) try {
  if (const int line = line_of_second_document(text); line > 0) {
    throw RepeatedKey(fmt::format("line {}: a second YAML document begins", line));
  }

  YAML::Node document = YAML::Load(text);
  std::size_t left = text.size() + 1;  // an empty text is a node, too
  require_unique_keys(document, left);
  return document;
} catch (const YAML::Exception& exception) {
  // The likely mistake: a colon that YAML takes for a nested map.
  const bool colon = exception.msg == YAML::ErrorMsg::MAP_VALUE;
  throw Error(fmt::format("line {}: not YAML: {}{}", std::max(exception.mark.line, 0) + 1,
                          exception.msg,
                          colon ? "; quote values that have a colon, e.g. name: 'a: b'" : ""));
}

}  // namespace slipstream
