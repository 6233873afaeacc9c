#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "slipstream/error.h"

namespace slipstream {

/// A map of scan.yaml; errors name the key. `where`: prefix of a nested map, such as "strategy: ".
class YamlMap {
 public:
  explicit YamlMap(YAML::Node node, std::string where = "")
      : node_(std::move(node)), where_(std::move(where)) {
    if (!node_.IsMap()) refuse("expected a map");
  }

  void require_known_keys(std::initializer_list<std::string_view> known) const {
    for (const std::string& key : keys()) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      refuse(
          fmt::format("key '{}' is not known; expected one of: {}", key, fmt::join(known, ", ")));
    }
  }

  [[nodiscard]] bool has(const std::string& key) const { return node_[key].IsDefined(); }

  [[nodiscard]] YamlMap map(const std::string& key) const {
    return YamlMap(required(key), key + ": ");
  }

  template <class Value>
  [[nodiscard]] Value value(const std::string& key, const char* wanted) const {
    return convert<Value>(required(key), key, wanted);
  }

  /// Reads a value if present.
  template <class Value>
  void read(const std::string& key, const char* wanted, Value& value) const {
    if (has(key)) value = this->value<Value>(key, wanted);
  }

  void read_number(const std::string& key, double& number) const {
    read(key, "a number", number);
    if (!std::isfinite(number)) refuse(fmt::format("{} is {}; it must be finite", key, number));
  }

  [[nodiscard]] int whole_number(const std::string& key, int least, int most) const {
    const int number = value<int>(key, "a whole number");
    if (number < least || number > most) {
      refuse(fmt::format("{} {} is out of range; expected {} to {}", key, number, least, most));
    }
    return number;
  }

  /// Requires at least one value, if present.
  template <class Value>
  [[nodiscard]] std::vector<Value> list(const std::string& key, const char* of,
                                        const char* wanted) const {
    std::vector<Value> values;
    if (!has(key)) return values;

    const YAML::Node list = node_[key];
    if (list.IsSequence()) {
      for (const auto& item : list) values.push_back(convert<Value>(item, key, wanted));
    }

    // An empty list, or a value that is not a list.
    if (values.empty()) refuse(fmt::format("{} is not a list of {}", key, of));
    return values;
  }

  /// A text, or a list of them.
  [[nodiscard]] std::vector<std::string> one_or_list(const std::string& key, const char* of,
                                                     const char* wanted) const {
    if (node_[key].IsScalar()) return {value<std::string>(key, wanted)};
    return list<std::string>(key, of, wanted);
  }

  [[nodiscard]] std::vector<std::string> keys() const {
    std::vector<std::string> keys;
    for (const auto& entry : node_) keys.push_back(entry.first.as<std::string>());
    return keys;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw Error(where_ + why); }

  [[nodiscard]] YAML::Node required(const std::string& key) const {
    if (!has(key)) refuse(fmt::format("key '{}' is missing", key));
    return node_[key];
  }

  template <class Value>
  [[nodiscard]] Value convert(const YAML::Node& node, const std::string& key,
                              const char* wanted) const try {
    return node.as<Value>();
  } catch (const YAML::Exception&) {
    refuse(fmt::format("{} is not {}", key, wanted));
  }

  YAML::Node node_;
  std::string where_;
};

}  // namespace slipstream
