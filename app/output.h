#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace slipstream::app {

/// Where a subcommand's words go: to stdout for people, or to stderr when stdout is for the one
/// JSON document that a machine reads. Control characters in them are shown as "\x1b".
class Output {
 public:
  explicit Output(bool json) : json_(json) {}

  /// One of the same kind whose lines wait for their turn: for `release` of this one.
  [[nodiscard]] Output held() const {
    Output output(json_);
    output.holds_ = true;
    return output;
  }
  /// Says what the other holds.
  void release(const Output& held);

  /// Whether somebody wants the document.
  [[nodiscard]] bool is_json() const { return json_; }

  /// A line for people.
  template <class... Values>
  void say(fmt::format_string<Values...> format, Values&&... values) {
    write_line(json_ ? stderr : stdout, fmt::format(format, std::forward<Values>(values)...));
  }

  /// A line on stderr that begins with "warning:".
  void warn(std::string_view message);
  /// A line on stderr that begins with the program's name.
  void tell_failure(std::string_view message);

  /// The document that `--json` prints. What is in it is made whole, here and by list and object:
  /// what [] or push_back make of nothing is broken where they get no memory.
  nlohmann::json document = nlohmann::json::object();

  /// That of the name in the document, empty where it was not there.
  nlohmann::json& list(const std::string& name) {
    return *document.emplace(name, nlohmann::json::array()).first;
  }
  nlohmann::json& object(const std::string& name) {
    return *document.emplace(name, nlohmann::json::object()).first;
  }

  /// What the program ends with once all is said: 2 where what it was to judge is bad.
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
  Progress(std::string label, std::int64_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// One more of `total` is done; `already`: before, which says nothing of the rate.
  void advance(bool already = false);

  /// Takes the bar away.
  void finish();

 private:
  void draw() const;

  std::string label_;
  std::int64_t total_;
  std::int64_t done_ = 0, done_before_ = 0;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slipstream::app
