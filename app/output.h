#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/flag_names.h"
#include "base/printable.h"
#include "slipstream/check.h"
#include "slipstream/cloud.h"
#include "slipstream/engine.h"
#include "slipstream/finding.h"
#include "slipstream/live_pipeline.h"

namespace slipstream {

/// A finding in JSON: `kind`, `what`, `evidence` by name, `likely`, `try`, `refused`, and as data
/// `quantities`, `causes`, `remedies`; `subject` and `frames` if it is about a part of the scan.
void to_json(nlohmann::json& json, const Finding& finding);
/// Both axes or a guard, compared by the epipolar lines: sizes in projector pixels, and counts.
void to_json(nlohmann::json& json, const EpipolarCheck& check);
/// A live diagnostic: adds `begin` and `end`, the frame sequence numbers at which it appeared and
/// disappeared; null while it lasts.
void to_json(nlohmann::json& json, const LiveFinding& finding);

}  // namespace slipstream

namespace slipstream::app {

/// The document with its texts with_flags, except names of files and settings as data.
nlohmann::json document_with_flags(nlohmann::json document);

/// Converts numbers and texts; an empty optional to null; lists; pairs of a name and a value to an
/// object; ValidityCounts by reason; and types with for_each_figure, see LiveStatistics.
template <class Value>
nlohmann::json as_json(const Value& value) {
  const auto nothing = [](auto&&...) {};
  nlohmann::json named = nlohmann::json::object();

  // The order matters: a text, a map and a list are all ranges.
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
    for (const auto& [name, item] : value) named[name] = as_json(item);
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

/// Adds values by name, describe(object, "frames", count, "rms_mm", rms), each converted by
/// as_json; empty optionals are omitted.
template <class Value, class... More>
void describe(nlohmann::json& object, const char* name, const Value& value, const More&... more) {
  if constexpr (requires { value.has_value(); }) {
    if (value) object[name] = as_json(*value);
  } else {
    object[name] = as_json(value);
  }
  if constexpr (sizeof...(more) > 0) describe(object, more...);
}

/// An object of only these values.
template <class... Named>
nlohmann::json described(const Named&... named) {
  nlohmann::json object = nlohmann::json::object();
  describe(object, named...);
  return object;
}

/// A list of `describe` applied to each.
template <class Values, class Describe>
nlohmann::json as_json(const Values& values, const Describe& describe) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& each : values) list.push_back(describe(each));
  return list;
}

/// A pose as a matrix: four rows of four, with the translation in mm.
nlohmann::json json_of(const Eigen::Isometry3d& pose);

/// A pose: `from`, `to`, and `matrix_mm`.
nlohmann::json json_of(const FramePose& pose);

/// A text as a part of a line: printable; other values as they are.
template <class Value>
decltype(auto) in_line(Value&& value) {
  if constexpr (std::is_convertible_v<Value, std::string_view>) {
    return printable(value);
  } else {
    return std::forward<Value>(value);
  }
}

/// The program's version and its arguments, as a shell takes them.
struct ProgramRunText {
  std::string version{};
  std::string command{};
};

/// A subcommand's output: text on stdout, or on stderr if stdout carries data. Texts are printed
/// with_flags, and control characters as "\x1b".
class Output {
 public:
  /// `piped`: stdout carries a file, so that text goes to stderr.
  explicit Output(bool json, bool piped = false) : json_(json), aside_(json || piped) {}

  /// An output of the same kind whose lines wait for `release` on this one.
  [[nodiscard]] Output held() const {
    Output output(json_, aside_);
    output.holds_ = true;
    return output;
  }

  /// Prints the lines held by the other.
  void release(const Output& held) {
    for (const auto& [stream, line] : held.held_) write_line(stream, line);
  }

  [[nodiscard]] bool is_json() const { return json_; }

  /// A line of text. Line breaks in texts among the values, such as names, are printed as "\x0a".
  template <class... Values>
  void say(fmt::format_string<Values...> format, Values&&... values) {
    say_lines(fmt::format(fmt::runtime(fmt::string_view(format)),
                          in_line(std::forward<Values>(values))...));
  }

  /// A text of one or more lines.
  void say_lines(std::string_view text) { write_line(aside_ ? stderr : stdout, with_flags(text)); }

  /// A line on stderr, prefixed with "warning:".
  void warn(std::string_view message) {
    write_line(stderr, fmt::format("warning: {}", with_flags(printable(message))));
  }

  void warn(const std::vector<std::string>& messages) {
    for (const std::string& message : messages) warn(message);
  }

  void warn(const std::vector<Finding>& findings) {
    for (const Finding& finding : findings) warn(text_of(finding));
  }

  /// A line on stderr, prefixed with the program's name.
  void tell_failure(std::string_view message) {
    write_line(stderr, fmt::format("slipstream: {}", with_flags(printable(message))));
  }

  /// Shows work that may take seconds, on a terminal alone and until the next line.
  void tell_wait(std::string_view work);

  /// The document that `--json` prints. Values are built before they are inserted, here and by list
  /// and object, as [] and push_back leave broken values when out of memory.
  nlohmann::json document = nlohmann::json::object();

  /// Adds values, see describe.
  template <class... Named>
  void add(const Named&... named) {
    describe(document, named...);
  }

  /// Adds an object of values to the document's list of that name.
  template <class... Named>
  void add_to(const std::string& list_name, const Named&... named) {
    list(list_name).push_back(described(named...));
  }

  /// The document's entry of that name, created empty if missing.
  nlohmann::json& list(const std::string& name) {
    return *document.emplace(name, nlohmann::json::array()).first;
  }

  nlohmann::json& object(const std::string& name) {
    return *document.emplace(name, nlohmann::json::object()).first;
  }

  /// Prints "NAME: PATH" for a written file and adds it to the document's `files`.
  void add_file(const std::string& name, const std::string& path) {
    say("{}: {}", name, path);
    object("files")[name] = path;
  }

  /// Prints a test's verdict and adds it as `grade` and `verdict`; sets the exit code 2 if "bad".
  void tell_verdict(std::string_view grade, const std::string& words);

  /// The program's exit code; 2 if a check failed.
  int exit_code = 0;

  /// For reports.
  ProgramRunText run{};

  /// Prints the document if requested. Throws WorldError if stdout fails.
  void finish();

 private:
  void write_line(std::FILE* stream, std::string_view line);

  void clear_wait();

  bool json_, aside_;
  bool holds_ = false;
  bool waits_ = false;  ///< work is shown
  std::vector<std::pair<std::FILE*, std::string>> held_{};
};

/// Progress on stderr: on a terminal a bar, which the destructor removes; elsewhere one line with
/// the share that is done, if all takes over a second.
class Progress {
 public:
  template <class Count>
  Progress(std::string label, Count total)
      : label_(std::move(label)), total_(static_cast<std::int64_t>(total)) {
    if (terminal_ && total_ > 1) draw();
  }

  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// Counts one more of `total` as done; with `already`, as done earlier, which does not count
  /// towards the rate.
  void advance(bool already = false);

  /// Counts `done` of `total` as done.
  void reach(std::int64_t done);

  /// Removes the bar.
  void finish();

 private:
  void show();
  void draw();

  std::string label_;
  std::int64_t total_, done_ = 0, done_before_ = 0;
  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool drawn_ = false, reported_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), drawn_at_;
};

/// Shows the share, 0 to 1, that it is called with as a Progress, from any one thread.
std::function<void(double)> progress_of(std::string label);

/// Prints warnings and repairs. Throws Error with the scan's name and all diagnostics, errors
/// first, if the scan is refused; with `anyway` prints them as warnings instead.
void refuse_or_warn(const CheckedScan& checked, const std::string& scan, bool anyway,
                    Output& output);

/// Prints findings of a scan as warnings, from the `first` on; those before it are printed already.
void warn_of_findings(const std::vector<Finding>& findings, std::size_t first,
                      const std::string& scan, Output& output);

/// doubts with the program's flags: header lines of a cloud file.
std::vector<std::string> remarks_about(const std::vector<Finding>& findings);

/// Prints each diagnostic that has appeared or disappeared since those `printed`, and
/// updates them.
void tell_news(const std::vector<LiveFinding>& findings, std::vector<LiveFinding>& printed,
               Output& output);

/// Prints Engine::fallback_reason, as a warning if `matters`; returns false if there is none.
bool tell_fallback(const std::string& reason, bool matters, Output& output);

}  // namespace slipstream::app
