#include "io/rig_file.h"

#include <algorithm>
#include <set>

#include <yaml-cpp/yaml.h>

#include "io/file.h"
#include "io/unique_keys.h"

namespace slipstream {
namespace {

[[noreturn]] void refuse(const YAML::Mark& mark, const std::string& why) {
  throw Error(fmt::format("line {}: {}", std::max(mark.line, 0) + 1, why));
}

std::string text_of(const YAML::Node& node, const std::string& setting, const YAML::Mark& mark) {
  if (node.IsScalar()) return node.Scalar();
  refuse(mark, fmt::format("{}: expected a value or a list of values", setting));
}

RigSetting setting_from(std::string name, const YAML::Node& node, const YAML::Mark& mark) {
  // A setting has the name of its flag, but may be written with underscores.
  std::replace(name.begin(), name.end(), '_', '-');

  RigSetting setting{.name = name, .line = mark.line + 1};
  if (!node.IsSequence()) {
    setting.values.push_back(text_of(node, name, mark));
  } else {
    for (const YAML::Node& value : node) setting.values.push_back(text_of(value, name, mark));
  }

  if (setting.values.empty()) refuse(mark, fmt::format("{}: the list is empty", name));
  return setting;
}

std::vector<RigSetting> settings_in(const YAML::Node& root) {
  if (!root.IsMap()) refuse(root.Mark(), "expected a map of settings, e.g. source: virtual");

  std::vector<RigSetting> settings;
  std::set<std::string> names;

  const auto add = [&](const YAML::Node& key, const YAML::Node& value) {
    settings.push_back(
        setting_from(text_of(key, "the name of a setting", key.Mark()), value, key.Mark()));
    add_key(names, settings.back().name, settings.back().line);
  };

  // Settings may be grouped in maps; the groups' names mean nothing.
  for (const auto& entry : root) {
    if (!entry.second.IsMap()) {
      add(entry.first, entry.second);
      continue;
    }
    for (const auto& inner : entry.second) add(inner.first, inner.second);
  }

  return settings;
}

}  // namespace

std::vector<RigSetting> read_rig(const std::filesystem::path& file) {
  return rig_from(read_text(file), file.string());
}

std::vector<RigSetting> rig_from(const std::string& text, const std::string& name) {
  return naming(name, [&] { return settings_in(yaml_document(text)); });
}

}  // namespace slipstream
