#include "app/help.h"

#include <algorithm>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/Formatter.hpp>
#include <sys/ioctl.h>
#include <unistd.h>

#include "app/commands.h"

namespace slipstream::app {
namespace {

constexpr std::size_t indent = 26;  ///< column at which descriptions start

/// Columns of the terminal, 60 to 120; 100 for a file or a pipe.
std::size_t line_length() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 100;
  return std::clamp<std::size_t>(size.ws_col, 60, 120);
}

/// The text's words in lines that start at `margin`. With `ending`, which ends all lines but the
/// last, values stay beside their flags.
std::string wrapped(const std::string& text, std::size_t margin, std::string_view ending = "") {
  // 1. Break the text into pieces that stay on one line: words, or a flag with its values.
  std::vector<std::string> pieces;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool is_value = !ending.empty() && !pieces.empty() && pieces.back().starts_with('-');
    if (is_value && !word.starts_with('-')) {
      pieces.back() += ' ' + word;
    } else {
      pieces.push_back(word);
    }
  }

  // 2. Fill lines with the pieces; `ending` is the shell's backslash.
  std::string lines;
  std::size_t column = margin;
  for (const std::string& word : pieces) {
    if (column > margin && column + 1 + word.size() + ending.size() > line_length()) {
      lines += fmt::format("{}\n{:{}}", ending, "", margin);
      column = margin;
    }
    if (column > margin) {
      lines += ' ';
      ++column;
    }
    lines += word;
    column += word.size();
  }

  return lines;
}

/// "  term   description", the description wrapped and indented.
std::string entry(const std::string& term, const std::string& description) {
  const bool fits = term.size() + 4 <= indent;
  return fmt::format("  {:<{}}{}\n", fits ? term : fmt::format("{}\n{:{}}", term, "", indent),
                     fits ? indent - 2 : 0, wrapped(description, indent));
}

/// The examples, their commands broken as a shell reads them.
std::string examples_of(const CLI::App& app) {
  std::string text;
  std::istringstream lines(app.get_footer());
  for (std::string line; std::getline(lines, line);) {
    text += line.starts_with("  ") ? fmt::format("  {}\n", wrapped(line, 6, " \\"))
                                   : wrapped(line, 0) + '\n';
  }
  return text.empty() ? "" : '\n' + text;
}

std::string entry(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) {
    if (!is_former_name(name)) names.push_back("--" + name);
  }

  // CLI11 names types for programmers; the help names them for users.
  std::string type = option.get_type_name();
  if (type == "INT" || type == "UINT") type = "N";
  if (type == "FLOAT") type = "NUMBER";
  if (type == output_type || type == scanner_output_type) type = file_type;

  // One word per value that the flag takes, "..." for a list.
  const int values = option.get_items_expected_max();
  const bool is_list = values >= CLI::detail::expected_max_vector_size;
  std::string term = fmt::format("{}", fmt::join(names, ", "));
  for (int i = 0; i < (is_list ? 1 : values); ++i) term += " " + type;

  const std::string usual = option.get_default_str();
  return entry(term + (is_list ? "..." : ""),
               option.get_description() + (option.get_required() ? " (required)"
                                           : usual.empty()       ? ""
                                                                 : " (default " + usual + ")"));
}

std::string section(const std::string& title, const std::string& entries) {
  return entries.empty() ? "" : fmt::format("\n{}:\n{}", title, entries);
}

std::string options_of(const CLI::App& app, const std::string& group) {
  std::string entries;
  for (const CLI::Option* const option : app.get_options()) {
    if (option->nonpositional() && option->get_group() == group) entries += entry(*option);
  }
  return entries;
}

/// Usage, examples, arguments, commands and common options; with --help-all, and for commands
/// without common options, all options in groups.
struct HelpLayout : CLI::Formatter {
  std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode mode) const override {
    // 1. The command as it is called: "slipstream calibrate gamma".
    std::string called = app->get_name(), usage, arguments, commands, group;
    for (const CLI::App* at = app->get_parent(); at != nullptr; at = at->get_parent()) {
      called = at->get_name() + " " + called;
    }

    // 2. Subcommands, under the heading of their group.
    for (const CLI::App* const command : app->get_subcommands([](auto*) { return true; })) {
      if (command->get_group() != group) commands += fmt::format("\n{}:\n", command->get_group());
      group = command->get_group();
      commands += entry(command->get_name(), command->get_description());
    }

    // 3. Arguments without a flag, for the usage line and their own section.
    for (const CLI::Option* const option : app->get_options()) {
      if (!option->get_positional()) continue;
      const std::string name = option->get_single_name();
      const std::string shown = name + (option->get_items_expected_max() > 1 ? "..." : "");
      usage += option->get_required() ? " " + shown : " [" + shown + "]";
      arguments += entry(name, option->get_description());
    }

    return fmt::format("{}: {}\n\nUsage: {}{} [OPTION]...{}\n", called, app->get_description(),
                       called, commands.empty() ? "" : " COMMAND", usage) +
           examples_of(*app) + section("Arguments", arguments) + commands +
           options_in_groups(*app, called, mode == CLI::AppFormatMode::All);
  }

 private:
  static std::string options_in_groups(const CLI::App& app, const std::string& called, bool all) {
    const std::string others = "Options";  // CLI11's group for options without one

    // Common options come in the order of their numbered groups, which the map sorts.
    std::map<std::string, std::string> common;
    std::string groups, first;
    for (const std::string& name : app.get_groups()) {
      if (name.starts_with(common_options)) {
        common[name] = options_of(app, name);
      } else if (name != others) {
        groups += section(name, options_of(app, name));
      }
    }

    for (const auto& [name, options] : common) first += options;

    // The short help ends with the common options.
    if (!first.empty() && !all) {
      const bool patterned = app.get_option_no_throw("--strategy") != nullptr;
      return section(common_options, first) +
             fmt::format("\nAll options: {} --help-all{}\n", called,
                         patterned ? "; those of the patterns: slipstream help patterns" : "");
    }

    return section(common_options, first) + groups +
           section(first.empty() ? others : "Other options", options_of(app, others));
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_layout() {
  return std::make_shared<HelpLayout>();
}

std::string greeting() {
  return "slipstream: 3-D reconstruction by structured light\n\nTo begin:\n" +
         entry("slipstream demo",
               "scan the virtual world: a scan and its cloud, without hardware") +
#ifdef SLIPSTREAM_VIEW
         entry("slipstream studio", "camera, projector and cloud in one window; or all virtual") +
#endif
         entry("slipstream patterns", "write the pictures that your projector shows") +
         entry("slipstream reconstruct", "make clouds out of your pictures") +
#ifdef SLIPSTREAM_ALL_COMMANDS
         entry("slipstream live",
               "clouds in real time; from the virtual scanner without a camera") +
#endif
         "\nAll commands: slipstream --help; one of them: slipstream help COMMAND";
}

}  // namespace slipstream::app
