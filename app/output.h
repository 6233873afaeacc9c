#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "slipstream/check/scan_check.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/live/live_statistics.h"

namespace slipstream {

/// A finding in JSON: `what`, `evidence` by name, `likely`, `try`, `refused`.
void to_json(nlohmann::json& json, const Finding& finding);
/// As a finding of a scan, with `begin` and `end`: sequence of the frames at which it was first
/// seen and first gone; null while it lasts.
void to_json(nlohmann::json& json, const LiveFinding& finding);

}  // namespace slipstream

namespace slipstream::app {

/// A number or a text as it is, null for an empty optional, a list of such, pairs of a name and
/// such as an object; ValidityCounts by the names of the reasons; what describes itself by its
/// names, see LiveStatistics::for_each_figure.
template <class Value>
nlohmann::json as_json(const Value& value) {
  const auto nothing = [](auto&&...) {};
  nlohmann::json named = nlohmann::json::object();
  if constexpr (std::is_same_v<Value, nlohmann::json> ||
                std::is_convertible_v<Value, std::string_view>) {
    return value;
  } else if constexpr (std::is_same_v<Value, ValidityCounts>) {
    for (std::size_t i = 0; i < validity_count; ++i) {
      named[std::string(name_of(static_cast<Validity>(i)))] = value[i];
    }
    return named;
  } else if constexpr (requires { value.for_each_figure(nothing); }) {
    value.for_each_figure([&](const char* name, const auto& figure, const auto&...) {
      named[name] = as_json(figure);
    });
    return named;
  } else if constexpr (requires { value.begin()->first; }) {
    for (const auto& [name, of] : value) named[name] = as_json(of);
    return named;
  } else if constexpr (requires { value.has_value(); }) {
    return value ? as_json(*value) : nlohmann::json();
  } else if constexpr (std::ranges::range<Value>) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& each : value) list.push_back(as_json(each));
    return list;
  } else {
    return value;
  }
}

/// Puts values into an object by their names, describe(object, "frames", count, "rms_mm", rms),
/// each as as_json says it; an optional that is empty is left out.
template <class Value, class... More>
void describe(nlohmann::json& object, const char* name, const Value& value, const More&... more) {
  if constexpr (requires { value.has_value(); }) {
    if (value) object[name] = as_json(*value);
  } else {
    object[name] = as_json(value);
  }
  if constexpr (sizeof...(more) > 0) describe(object, more...);
}

/// An object of these alone.
template <class... Named>
nlohmann::json described(const Named&... named) {
  nlohmann::json object = nlohmann::json::object();
  describe(object, named...);
  return object;
}

/// A list of what `describe` says of each.
template <class Values, class Describe>
nlohmann::json as_json(const Values& values, const Describe& describe) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& each : values) list.push_back(describe(each));
  return list;
}

/// Where a subcommand's words go: to stdout for people, or to stderr when stdout is for the one
/// JSON document that a machine reads. Control characters in them are shown as "\x1b".
class Output {
 public:
  explicit Output(bool json) : json_(json) {}

  /// One of the same kind whose lines wait for `release` of this one.
  [[nodiscard]] Output held() const {
    Output output(json_);
    output.holds_ = true;
    return output;
  }
  /// Says what the other holds.
  void release(const Output& held);

  /// Whether the document is wanted.
  [[nodiscard]] bool is_json() const { return json_; }

  /// A line for people.
  template <class... Values>
  void say(fmt::format_string<Values...> format, Values&&... values) {
    write_line(json_ ? stderr : stdout, fmt::format(format, std::forward<Values>(values)...));
  }

  /// A line on stderr that begins with "warning:".
  void warn(std::string_view message);
  void warn(const std::vector<std::string>& messages) {
    for (const std::string& message : messages) warn(message);
  }
  void warn(const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) warn(text_of(finding));
  }
  /// A line on stderr that begins with the program's name.
  void tell_failure(std::string_view message);

  /// The document that `--json` prints. What is in it is made whole, here and by list and object:
  /// what [] or push_back make of nothing is broken where they get no memory.
  nlohmann::json document = nlohmann::json::object();

  /// Puts values into it, see describe.
  template <class... Named>
  void add(const Named&... named) {
    describe(document, named...);
  }
  /// That of the name in the document, empty where it was not there.
  nlohmann::json& list(const std::string& name) {
    return *document.emplace(name, nlohmann::json::array()).first;
  }
  nlohmann::json& object(const std::string& name) {
    return *document.emplace(name, nlohmann::json::object()).first;
  }
  /// Says that the file was written, "NAME: PATH", and puts it among the document's `files`.
  void add_file(const std::string& name, const std::string& path) {
    say("{}: {}", name, path);
    object("files")[name] = path;
  }

  /// The program's exit code once all is said; 2 if what it judges is bad.
  int exit_code = 0;

  /// Prints the document if it is wanted. Throws WorldError when stdout does not take it.
  void finish();

 private:
  void write_line(std::FILE* stream, std::string_view line);

  bool json_;
  bool holds_ = false;
  std::vector<std::pair<std::FILE*, std::string>> held_{};
};

/// A bar on stderr that fills as work is done: shown only on a terminal, and only once the work has
/// taken a second. Removed when it goes out of scope.
class Progress {
 public:
  template <class Count>
  Progress(std::string label, Count total)
      : label_(std::move(label)), total_(static_cast<std::int64_t>(total)) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// One more of `total` is done; `already`: before, which does not count towards the rate.
  void advance(bool already = false);

  /// Removes the bar.
  void finish();

 private:
  void draw() const;

  std::string label_;
  std::int64_t total_, done_ = 0, done_before_ = 0;
  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Warns of all that is doubtful and says what was repaired. If something is wrong throws Error,
/// naming the scan and all findings, what is wrong first; with `anyway` it warns of that too.
void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output);

/// Warns of each finding that has begun since `told`, which it updates, and says which have ended.
void tell_news(const std::vector<LiveFinding>& findings, std::vector<LiveFinding>& told,
               Output& output);

/// Warns of Engine::fallback_reason; false without one.
bool warn_of_fallback(const std::string& failure, Output& output);

}  // namespace slipstream::app
