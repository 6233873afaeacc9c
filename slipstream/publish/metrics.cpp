#include "slipstream/publish/metrics.h"

#include <algorithm>
#include <array>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {
using nlohmann::json;

constexpr std::array counts{
    "captured",           "lost",      "overwritten",  "repeated", "clouds", "done",
    "resynchronisations", "published", "windows_lost", "missed",   "dropped"};

/// Samples of each metric, together as the form wants them.
using Metrics = std::map<std::string, std::string>;

std::string escaped_label(const std::string& label) {
  std::string text;
  for (const char c : label) {
    if (c == '\\' || c == '"') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text;
}

void add(const json& value, const std::string& name, const std::string& labels, Metrics& metrics) {
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items()) {
      const bool count = std::find(counts.begin(), counts.end(), key) != counts.end();
      std::string word = key;
      std::replace_if(
          word.begin(), word.end(), [](char c) { return !std::isalnum(c); }, '_');
      const char* const ending = count && inner.is_number() ? "_total" : "";
      add(inner, fmt::format("{}_{}{}", name, word, ending), labels, metrics);
    }
  } else if (value.is_array()) {
    const bool objects = std::all_of(value.begin(), value.end(), [](const json& one) {
      return one.is_object() && !one.contains("name");
    });
    if (objects) metrics[name] += fmt::format("{} {}\n", name, value.size());
    for (std::size_t i = 0; i < value.size() && !objects; ++i) {
      const json& one = value[i];
      const bool named = one.is_object();
      add(one, name,
          fmt::format("{{{}=\"{}\"}}", named ? "name" : "index",
                      named ? escaped_label(one["name"].get<std::string>()) : std::to_string(i)),
          metrics);
    }
  } else if (value.is_number()) {
    metrics[name] += fmt::format("{}{} {}\n", name, labels, value.dump());
  }
}

}  // namespace

std::string metrics_of(std::string_view statistics) {
  const json document = json::parse(statistics, nullptr, false);
  if (document.is_discarded()) throw Error("statistics that are no JSON");
  Metrics metrics;
  add(document, "slipstream", "", metrics);
  std::string text;
  for (const auto& [name, samples] : metrics) {
    text += fmt::format("# TYPE {} {}\n{}", name, name.ends_with("_total") ? "counter" : "gauge",
                        samples);
  }
  return text;
}

}  // namespace slipstream
