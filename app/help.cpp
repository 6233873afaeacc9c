#include <sstream>

#include <CLI/Formatter.hpp>
#include <sys/ioctl.h>
#include <unistd.h>

#include "app/commands.h"

namespace slipstream::app {
namespace {

constexpr std::size_t indent = 26;  ///< column at which descriptions start

/// Columns of the terminal, 60 to 120; 100 for a file or a pipe.
std::size_t text_width() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 100;
  return std::clamp<std::size_t>(size.ws_col, 60, 120);
}

/// "  term   description", the description wrapped and indented.
std::string entry(const std::string& term, const std::string& description) {
  const std::string next_line = '\n' + std::string(indent, ' ');
  const bool fits = term.size() + 4 <= indent;
  std::string text = fits ? fmt::format("  {:<{}}", term, indent - 2) : "  " + term + next_line;
  std::size_t column = indent;
  std::istringstream words(description);
  for (std::string word; words >> word; column += word.size()) {
    if (column > indent && column + 1 + word.size() > text_width()) {
      text += next_line;
      column = indent;
    }
    if (column++ > indent) text += ' ';
    text += word;
  }
  return text + '\n';
}

std::string entry(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  std::string type = option.get_type_name();
  if (type == "INT" || type == "UINT") type = "N";
  if (type == "FLOAT") type = "NUMBER";
  if (type == output_type || type == scanner_output_type) type = file_type;
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

/// Usage, arguments, commands, common options, the other groups, and examples.
struct HelpLayout : CLI::Formatter {
  std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const override {
    std::string called = app->get_name(), usage, arguments, commands, group;
    for (const CLI::App* at = app->get_parent(); at != nullptr; at = at->get_parent()) {
      called = at->get_name() + " " + called;
    }
    for (const CLI::App* const command : app->get_subcommands([](auto*) { return true; })) {
      if (command->get_group() != group) commands += fmt::format("\n{}:\n", command->get_group());
      group = command->get_group();
      commands += entry(command->get_name(), command->get_description());
    }
    for (const CLI::Option* const option : app->get_options()) {
      if (!option->get_positional()) continue;
      const std::string name = option->get_single_name();
      const std::string shown = name + (option->get_items_expected_max() > 1 ? "..." : "");
      usage += option->get_required() ? " " + shown : " [" + shown + "]";
      arguments += entry(name, option->get_description());
    }
    const std::string others = "Options";  // CLI11's group for options without one
    std::map<std::string, std::string> common;
    std::string groups;
    for (const std::string& name : app->get_groups()) {
      if (name.starts_with(common_options)) {
        common[name] = options_of(*app, name);
      } else if (name != others) {
        groups += section(name, options_of(*app, name));
      }
    }
    std::string first;
    for (const auto& [name, options] : common) first += options;
    const std::string examples = app->get_footer();
    return fmt::format("{}: {}\n\nUsage: {}{} [OPTION]...{}\n", called, app->get_description(),
                       called, commands.empty() ? "" : " COMMAND", usage) +
           section("Arguments", arguments) + commands + section(common_options, first) + groups +
           section(first.empty() ? others : "Other options", options_of(*app, others)) +
           (examples.empty() ? "" : "\n" + examples + "\n");
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_layout() {
  return std::make_shared<HelpLayout>();
}

}  // namespace slipstream::app
